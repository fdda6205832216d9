import type { Labels_Label as Label } from "../../protocol/gen/api/proto/stream_pb";
import { Modality } from "../../protocol/messages";
import type { Scene } from "../../protocol/gen/api/proto/scene_pb";
import * as looks from "../../scene/labels";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Icon } from "../icons";
import { ColourControl, NumberControl, Switch, type PictureWindowProps } from "../viewer/settings/controls";
import { sceneEdits } from "../viewer/settings/scene_edits";
import { nameOf } from "./label_name";
import { useMarked } from "./use_marked";

/** The structures that somebody has marked in the scan, and how each is shown. */
export function LabelsWindow({ session, picture }: PictureWindowProps) {
  const scene = session.editor.scene.value;
  const labels = session.labels.value;
  const { chosenLabel } = session.slices;
  if (!scene) return null;
  const { once } = sceneEdits(session.editor);
  return (
    <>
      <p class="hint">{t.labels.lead}</p>
      <Origin labels={labels} />
      <Switch
        label={t.labels.coloured}
        on={looks.areColoured(scene, labels)}
        change={once("labels coloured", (now, on: boolean) => looks.setColoured(now, labels, on))}
      />
      <p>
        <button
          type="button"
          class="button button-small"
          onClick={() =>
            (picture.picking.value = {
              label: t.labels.press,
              pick: (at) => nameAt(session, at),
              end: t.labels.done,
            })
          }
        >
          <Icon name="tag" />
          {t.labels.name}
        </button>
      </p>
      <ul class="label-list">
        {labels.map((label) => (
          <Row
            key={label.number}
            session={session}
            scene={scene}
            label={label}
            chosen={chosenLabel.value === label.number}
            choose={() => (chosenLabel.value = chosenLabel.value === label.number ? null : label.number)}
          />
        ))}
      </ul>
      <Switch
        label={t.labels.rest}
        on={looks.isShown(scene, looks.unlabelled)}
        change={once("label 0 shown", (now, on: boolean) => looks.setShown(now, looks.unlabelled, on))}
      />
    </>
  );
}

/** Says which labels the server has found, because nobody has checked them. */
function Origin({ labels }: { readonly labels: readonly Label[] }) {
  const found = labels.filter(({ number }) => looks.foundPart(number));
  if (found.length === 0) return null;
  const text = found.length === labels.length ? t.labels.allFound : t.labels.someFound(found.map(nameOf).join(", "));
  return (
    <p class="hint" data-testid="labels-found">
      {text}
    </p>
  );
}

/** Returns the name of the label at a point of the picture, and chooses it in the list. */
async function nameAt(session: ViewerSession, { x, y }: { readonly x: number; readonly y: number }): Promise<string> {
  const answer = await session.depthAt(x, y);
  if (!answer.answered) return t.labels.noAnswer;
  if (!answer.seen) return t.labels.nothingThere;
  const number = answer.seen.label;
  const label = session.labels.value.find((one) => one.number === number);
  if (!label) return t.labels.unmarked;
  session.slices.chosenLabel.value = number;
  return nameOf(label);
}

interface RowProps {
  readonly session: ViewerSession;
  readonly scene: Scene;
  readonly label: Label;
  readonly chosen: boolean;
  readonly choose: () => void;
}

/** One label: whether it is shown, its name and volume, and once it is chosen, its look. */
function Row({ session, scene, label, chosen, choose }: RowProps) {
  const { once } = sceneEdits(session.editor);
  const { number } = label;
  const name = nameOf(label);
  const row = useMarked(chosen);
  const solo = looks.isSolo(scene, number);
  return (
    <li data-label={number} ref={row}>
      <div class="label-row">
        <input
          type="checkbox"
          aria-label={t.labels.show(name)}
          checked={looks.isShown(scene, number)}
          onChange={(event) =>
            once(`label ${number} shown`, (now, on: boolean) => looks.setShown(now, number, on))(
              event.currentTarget.checked,
            )
          }
        />
        <button type="button" class="label-name" aria-expanded={chosen} onClick={choose}>
          <Swatch scene={scene} label={label} />
          {name}
        </button>
        <span class="muted">{t.labels.volume(label.volume / 1000)}</span>
        <button
          type="button"
          class="button button-small"
          aria-pressed={solo}
          aria-label={t.labels.onlyOf(name)}
          onClick={() => {
            if (!solo) showMatterOf(session, number);
            once(`label ${number} alone`, (now, on: boolean) => looks.setSolo(now, number, on))(!solo);
          }}
        >
          {t.labels.only}
        </button>
      </div>
      {chosen ? <Look session={session} scene={scene} label={label} /> : null}
    </li>
  );
}

/**
 * Chooses the look that suits a part which the server has found. Other looks may not show its matter, such as air, or
 * cover bone with the flesh around it.
 */
function showMatterOf(session: ViewerSession, number: number): void {
  const part = looks.foundPart(number);
  const { editor } = session;
  const fitting = editor.presets.value.find(({ name }) => part && name === looks.lookOfPart[part]);
  const active = editor.activePreset(); // null if the user has changed the materials
  if (fitting && active && active !== fitting) editor.applyPreset(fitting);
}

function Swatch({ scene, label }: Pick<RowProps, "scene" | "label">) {
  return (
    <svg class="swatch" viewBox="0 0 10 10" aria-hidden="true">
      <circle cx="5" cy="5" r="4.500" fill={looks.shownColour(scene, label)} />
    </svg>
  );
}

function Look({ session, scene, label }: Pick<RowProps, "session" | "scene" | "label">) {
  const { live, rest } = sceneEdits(session.editor);
  const { number } = label;
  const hounsfield = session.volume.value?.modality === Modality.CT;
  return (
    <div class="label-look" role="group" aria-label={nameOf(label)}>
      <ColourControl
        label={t.labels.colour}
        value={looks.lookOf(scene, number)?.colour ?? looks.suggestedColour(label)}
        change={live(`label ${number} colour`, (now, colour) => looks.setColour(now, number, colour))}
        rest={rest}
      />
      <NumberControl
        label={t.labels.opacity}
        unit={t.settings.percent}
        value={Math.round(100 * looks.opacityOf(scene, number))}
        limits={{ low: 0, high: 100 }}
        change={live(`label ${number} opacity`, (now, percent: number) => looks.setOpacity(now, number, percent / 100))}
        rest={rest}
      />
      {label.minimum <= label.maximum ? (
        <p class="hint label-values">
          {t.slices.ellipse(label.mean, label.deviation, hounsfield)}
          <br />
          {t.slices.ellipseRange(label.minimum, label.maximum, hounsfield)}
        </p>
      ) : null}
    </div>
  );
}
