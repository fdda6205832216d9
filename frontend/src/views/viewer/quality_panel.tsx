import { useState } from "preact/hooks";
import { local } from "../../storage";
import { place, t } from "../../texts";
import type { PictureFacts } from "../../video/picture_facts";
import type { ViewerSession } from "../../video/viewer_session";
import { percentText } from "../format";
import { Icon } from "../icons";
import { ErrorCurvePart } from "./error_curve";
import { KernelFacts } from "./kernel_facts";
import { qualityState, type QualityState } from "./quality_state";
import { TreatmentFacts } from "./treatment";

const key = "diaphane.quality";
const detailsKey = "diaphane.quality.details";
const smallScreen = () => matchMedia("(max-width: 900px), (max-height: 480px)").matches;

interface QualityProps {
  readonly session: ViewerSession;
  readonly facts: PictureFacts;
}

/** Whether the picture is finished, in plain words. The figures are behind "Details". */
export function QualityPanel({ session }: { readonly session: ViewerSession }) {
  const [open, setOpen] = useState(() => {
    const stored = local.getItem(key);
    return stored === null ? !smallScreen() : stored === "open";
  });
  // Next to the slices, the picture is small, so the panel is closed until the user opens it.
  const [openBesideSlices, setOpenBesideSlices] = useState(false);
  const besideSlices = session.slices.open.value;
  const shown = besideSlices ? openBesideSlices : open;
  const facts = session.pictures.picture.value;
  if (!facts) return null;
  const toggle = () => {
    if (besideSlices) {
      setOpenBesideSlices(!shown);
      return;
    }
    local.setItem(key, open ? "closed" : "open");
    setOpen(!open);
  };
  const finished = session.pictures.converged.value || session.pictures.lossless.value !== null;
  const state = qualityState(facts, session.effort.value, finished);
  if (!shown) return <QualityChip state={state} toggle={toggle} />;
  return (
    <section class="glass quality" aria-label={t.viewer.quality}>
      <div class="quality-head">
        <h2>{t.viewer.quality}</h2>
        <span class={`chip${state.finished ? " chip-good" : ""}`} data-fact="state">
          {state.text}
        </span>
        <button type="button" class="icon-button" aria-label={t.close} title={t.close} aria-expanded onClick={toggle}>
          <Icon name="close" />
        </button>
      </div>
      <QualityDetails session={session} facts={facts} />
    </section>
  );
}

/** The closed panel. */
function QualityChip({ state, toggle }: { readonly state: QualityState; readonly toggle: () => void }) {
  return (
    <button
      type="button"
      class="glass quality-chip"
      aria-label={`${t.viewer.qualityOpen}: ${state.text}`}
      aria-expanded={false}
      onClick={toggle}
    >
      <Icon name="chart" />
      <span class="in-words">{state.text}</span>
      {state.part === null ? null : <span class="in-figures">{percentText(Math.floor(100 * state.part) / 100)}</span>}
    </button>
  );
}

function QualityDetails({ session, facts }: QualityProps) {
  const [open, setOpen] = useState(() => local.getItem(detailsKey) === "open");
  const lossless = session.pictures.lossless.value;
  return (
    <details
      class="more quality-details"
      open={open}
      onToggle={(event) => {
        local.setItem(detailsKey, event.currentTarget.open ? "open" : "closed");
        setOpen(event.currentTarget.open);
      }}
    >
      <summary>{t.viewer.details}</summary>
      <QualityFigures session={session} facts={facts} />
      {facts.smoothed ? (
        <p class="quality-help" data-fact="denoised">
          {t.viewer.smoothedHelp}
        </p>
      ) : null}
      {lossless ? (
        <p class="quality-help" data-fact="lossless" title={t.viewer.losslessHelp}>
          {t.viewer.lossless(lossless.samples)}
        </p>
      ) : null}
      <TreatmentFacts session={session} />
      {open ? <ErrorCurvePart session={session} /> : null}
      <KernelFacts session={session} />
      <p class="quality-device muted">{t.kernel.device(session.device.value)}</p>
    </details>
  );
}

function QualityFigures({ session, facts }: QualityProps) {
  const rate = session.samplesPerSecond.value;
  const speed = rate > 0 && !session.pictures.converged.value ? t.viewer.perSecond(rate) : "";
  const error = Number.isFinite(facts.error) ? t.viewer.percent(facts.error) : t.viewer.errorUnknown;
  return (
    <dl>
      <Row name={t.viewer.error} help={t.viewer.errorHelp} value={error} mark="error" />
      <Row
        name={t.viewer.samples}
        value={facts.samples.toLocaleString(place())}
        mark="samples"
        {...(speed ? { aside: speed } : {})}
      />
      <Row name={t.viewer.time} value={t.viewer.seconds(facts.seconds)} mark="time" />
    </dl>
  );
}

interface RowProps {
  readonly name: string;
  readonly value: string;
  readonly mark: string;
  readonly help?: string;
  readonly aside?: string;
}

function Row({ name, value, mark, help, aside }: RowProps) {
  const [shown, setShown] = useState(false);
  return (
    <>
      <div class="quality-row">
        <dt>
          {name}
          {help ? (
            <button
              type="button"
              class="hint-button"
              aria-expanded={shown}
              aria-label={`${name}?`}
              title={help}
              onClick={() => setShown(!shown)}
            >
              ?
            </button>
          ) : null}
        </dt>
        <dd data-fact={mark}>
          {value}
          {aside ? <small> ({aside})</small> : null}
        </dd>
      </div>
      {help && shown ? <p class="quality-help">{help}</p> : null}
    </>
  );
}
