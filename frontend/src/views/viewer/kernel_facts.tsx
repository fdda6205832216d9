import { useEffect, useState } from "preact/hooks";
import { KernelOrigin, type KernelReport } from "../../protocol/file_messages";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";

/**
 * Time for which a view must be shown before its kernel is requested: longer than a pause within a
 * gesture, and than the minimum interval that the worker allows.
 */
const calmMs = 1000;

/** The features that the render kernel includes and those that it leaves out. Shown on request. */
export function KernelFacts({ session }: { readonly session: ViewerSession }) {
  const [open, setOpen] = useState(false);
  const epoch = session.pictures.picture.value?.epoch;
  const { phase } = session.connection.value;
  const text = t.kernel;
  useEffect(() => {
    if (!open || phase !== "live") return;
    // Another scene or another worker may use a different kernel.
    const timer = setTimeout(() => session.askForKernel(), session.kernel.value ? calmMs : 0);
    return () => clearTimeout(timer);
  }, [open, epoch, phase, session]);
  const report = session.kernel.value;
  return (
    <div class="kernel">
      <button type="button" aria-expanded={open} onClick={() => setOpen(!open)}>
        {text.open}
      </button>
      {open ? (
        <div class="kernel-facts" aria-live="polite">
          {report ? <Facts report={report} /> : <p>{t.loading}</p>}
        </div>
      ) : null}
    </div>
  );
}

function Facts({ report }: { readonly report: KernelReport }) {
  const text = t.kernel;
  const named = (names: readonly string[]) =>
    names.length === 0 ? text.nothing : names.map((name) => text.features[name] ?? name).join(", ");
  return (
    <>
      <p>{originOf(report)}</p>
      {report.origin === KernelOrigin.GENERAL ? null : ( // the general kernel has every feature
        <dl>
          <dt>{text.leftOut}</dt>
          <dd data-fact="left-out">{named(report.leftOut)}</dd>
          <dt>{text.compiledIn}</dt>
          <dd data-fact="compiled-in">{named(report.compiledIn)}</dd>
        </dl>
      )}
      <p>
        {[
          report.emptyCells === undefined ? "" : text.empty(report.emptyCells),
          report.registers === undefined ? "" : text.registers(report.registers),
        ]
          .filter(Boolean)
          .join(" ")}
      </p>
    </>
  );
}

function originOf({ origin, fromCache, compileMilliseconds }: KernelReport): string {
  const text = t.kernel;
  if (origin === KernelOrigin.FOR_THIS_SCENE)
    return fromCache ? text.fromCache : text.forThisScene(compileMilliseconds);
  return origin === KernelOrigin.GENERAL ? text.general : text.aheadOfTime;
}
