import { useState } from "preact/hooks";
import { local } from "../../storage";
import { place, t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Icon } from "../icons";
import { ErrorPlot } from "./error_plot";
import { KernelFacts } from "./kernel_facts";

const key = "diaphane.quality";
const small_screen = () => matchMedia("(max-width: 700px), (max-height: 480px)").matches;

/** Samples, error and its fall: there for who wants to know, folded away by a press. */
export function QualityPanel({ session }: { readonly session: ViewerSession }) {
  const [open, set_open] = useState(() => {
    const stored = local.getItem(key);
    return stored === null ? !small_screen() : stored === "open";
  });
  const facts = session.picture.value;
  if (!facts) return null;
  const toggle = () => {
    local.setItem(key, open ? "closed" : "open");
    set_open(!open);
  };
  const error = Number.isFinite(facts.error) ? t.viewer.percent(facts.error) : t.viewer.error_unknown;
  const lossless = session.lossless.value ? t.viewer.lossless(session.lossless.value.samples) : "";
  const rate = session.samples_per_second.value;
  const speed = rate > 0 && !session.converged.value ? t.viewer.per_second(rate) : "";
  if (!open)
    return (
      <button type="button" class="glass quality-chip" aria-label={`${t.viewer.quality_open}: ${lossless || error}`} aria-expanded={false} onClick={toggle}>
        <Icon name="chart" />
        <span>{lossless || error}</span>
      </button>
    );
  return (
    <section class="glass quality" aria-label={t.viewer.quality}>
      <div class="quality-head">
        <h2>{t.viewer.quality}</h2>
        <span
          class={`chip${session.converged.value || lossless ? " chip-good" : ""}`}
          data-fact="state"
          title={lossless ? t.viewer.lossless_help : facts.smoothed && !session.converged.value ? t.viewer.smoothed_help : undefined}
        >
          {lossless ? lossless : session.converged.value ? t.viewer.finished : facts.smoothed ? t.viewer.smoothed : t.viewer.refining}
        </span>
        <button type="button" class="icon-button" aria-label={t.close} title={t.close} aria-expanded onClick={toggle}><Icon name="close" /></button>
      </div>
      <dl>
        <Row name={t.viewer.error} help={t.viewer.error_help} value={error} mark="error" />
        <Row name={t.viewer.samples} value={facts.samples.toLocaleString(place())} mark="samples" {...(speed ? { aside: speed } : {})} />
        <Row name={t.viewer.time} value={t.viewer.seconds(facts.seconds)} mark="time" />
      </dl>
      <ErrorPlot points={session.curve.value} />
      <KernelFacts session={session} />
      <p class="quality-device muted">{session.device.value}</p>
    </section>
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
  const [shown, set_shown] = useState(false);
  return (
    <>
      <div class="quality-row">
        <dt>
          {name}
          {help ? (
            <button type="button" class="hint-button" aria-expanded={shown} aria-label={`${name}?`} title={help} onClick={() => set_shown(!shown)}>?</button>
          ) : null}
        </dt>
        <dd data-fact={mark}>{aside ? <small>{aside} </small> : null}{value}</dd>
      </div>
      {help && shown ? <p class="quality-help">{help}</p> : null}
    </>
  );
}
