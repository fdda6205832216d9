import { markKinds, withSet, type Mark, type MarkKind } from "../../marks/mark";
import type { Marks } from "../../marks/marks";
import { saidOf } from "../../marks/said";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Field } from "../field";
import { IconButton } from "../icon_button";
import { Icon, type IconName } from "../icons";
import { nameOf } from "../viewer/share_dialog";
import { Switch, type WindowProps } from "../viewer/settings/controls";
import { SavedMarks } from "./saved_marks";

/** The window in which marks are created, changed and saved. */
export function MarksWindow({ session }: WindowProps) {
  const { marks } = session;
  const chosen = marks.find(marks.selected.value);
  const audience = session.audience.value;
  const unseen = audience !== null && !audience.guestPointers && !session.collaboration.points.value;
  const others = (audience?.participants.length ?? 0) > 1;
  return (
    <>
      <p class="hint">{t.marks.lead}</p>
      {others && unseen ? <p class="hint">{t.marks.guestsOff}</p> : null}
      <Tools marks={marks} />
      <Colours marks={marks} chosen={chosen} />
      {chosen && marks.isOwn(chosen) ? (
        <Field
          label={t.marks.text}
          value={chosen.text}
          onInput={(text) => marks.setText(chosen.id, text)}
          most={80}
          hint={t.marks.textHint}
        />
      ) : null}
      <Switch label={t.marks.shown} on={marks.shown.value} change={(on) => (marks.shown.value = on)} />
      <h3>{t.marks.here}</h3>
      <MarkList session={session} />
      <SavedMarks session={session} />
    </>
  );
}

const icons: Readonly<Record<MarkKind, IconName>> = {
  arrow: "arrow",
  circle: "ring",
  text: "letter",
  ruler: "ruler",
  angle: "angle",
};

function Tools({ marks }: { readonly marks: Marks }) {
  const tool = marks.tool.value;
  return (
    <>
      <div class="mark-tools" role="group" aria-label={t.settings.windows.marks}>
        {markKinds.map((kind) => (
          <button
            key={kind}
            type="button"
            class="button button-small"
            data-tool={kind}
            aria-pressed={tool === kind}
            onClick={() => (marks.tool.value = tool === kind ? null : kind)}
          >
            <Icon name={icons[kind]} />
            {t.marks.kinds[kind]}
          </button>
        ))}
        <span class="mark-steps">
          <IconButton
            icon="undo"
            label={t.settings.undo}
            disabled={!marks.canUndo.value}
            onClick={() => marks.undo()}
          />
          <IconButton
            icon="redo"
            label={t.settings.redo}
            disabled={!marks.canRedo.value}
            onClick={() => marks.redo()}
          />
        </span>
      </div>
      <p class="hint" role="status">
        {tool === null ? "" : t.marks.press[tool]}
      </p>
    </>
  );
}

/** The colour of the chosen mark and of the next ones. */
function Colours({ marks, chosen }: { readonly marks: Marks; readonly chosen: Mark | null }) {
  const colour = chosen?.colour ?? marks.colour.value;
  const choose = (index: number) => {
    marks.colour.value = index;
    if (!chosen || !marks.isOwn(chosen)) return;
    marks.change("colour", chosen.id, (mark) => ({ ...mark, colour: index }));
    marks.rest();
  };
  return (
    <fieldset class="mark-colours">
      <legend>{t.marks.colour}</legend>
      {t.marks.colours.map((name, index) => (
        <label key={name} title={name} data-colour={index}>
          <input
            type="radio"
            name="mark-colour"
            aria-label={name}
            checked={index === colour}
            onChange={() => choose(index)}
          />
          <span aria-hidden="true" />
        </label>
      ))}
    </fieldset>
  );
}

/** The marks of this viewer, which can be chosen and deleted, and those of the others, which can be copied. */
function MarkList({ session }: { readonly session: ViewerSession }) {
  const { marks } = session;
  const people = session.collaboration.people.value;
  const others = marks.othersList.value;
  if (marks.items.value.length + others.length === 0) return <p class="hint">{t.marks.none}</p>;
  return (
    <ul class="mark-list">
      {marks.items.value.map((mark) => (
        <OwnRow key={mark.id} session={session} mark={mark} />
      ))}
      {others.map(({ number, mark }) => {
        const name = t.marks.nameOf(mark.kind, saidOf(mark));
        return (
          <li key={`${number}.${mark.id}`} data-colour={mark.colour}>
            <Icon name={icons[mark.kind]} />
            <span class="mark-name">
              {name} <small class="muted">{t.marks.by(nameOf(people, number))}</small>
            </span>
            <IconButton
              icon="copy"
              label={t.marks.keepOf(name)}
              title={t.marks.keep}
              onClick={() => marks.add(withSet(mark))}
            />
          </li>
        );
      })}
    </ul>
  );
}

function OwnRow({ session, mark }: { readonly session: ViewerSession; readonly mark: Mark }) {
  const { marks, slices } = session;
  const name = t.marks.nameOf(mark.kind, saidOf(mark));
  const choose = () => {
    marks.selected.value = mark.id;
    const axial = slices.stacks.value.get("axial");
    if (axial && slices.open.value && !slices.following.value) slices.pointAt(axial, mark.place);
  };
  return (
    <li data-colour={mark.colour}>
      <Icon name={icons[mark.kind]} />
      <button
        type="button"
        class="mark-name"
        aria-label={t.marks.choose(name)}
        aria-pressed={marks.selected.value === mark.id}
        onClick={choose}
      >
        {name}
      </button>
      {marks.isOwn(mark) ? (
        <IconButton
          icon="trash"
          label={t.marks.removeOf(name)}
          title={t.marks.remove}
          onClick={() => marks.remove(mark.id)}
        />
      ) : null}
    </li>
  );
}
