import { useEffect, useState } from "preact/hooks";
import { KernelOrigin, type KernelReport } from "../../protocol/file_messages";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";

/** Longer than a hand that moves rests, and than the worker wants to be left alone. */
const calm_ms = 1000;

/** What the program that renders the picture has in it, and what was left out: on request, in plain words. */
export function KernelFacts({ session }: { readonly session: ViewerSession }) {
  const [open, set_open] = useState(false);
  const epoch = session.picture.value?.epoch;
  const { phase } = session.connection.value;
  const text = t.kernel;
  useEffect(() => {
    if (!open || phase !== "live") return;
    // Another scene, or another worker, may have another program.
    const timer = setTimeout(() => session.ask_for_kernel(), session.kernel.value ? calm_ms : 0);
    return () => clearTimeout(timer);
  }, [open, epoch, phase, session]);
  const report = session.kernel.value;
  return (
    <div class="kernel">
      <button type="button" aria-expanded={open} onClick={() => set_open(!open)}>{text.open}</button>
      {open ? <div class="kernel-facts" aria-live="polite">{report ? <Facts report={report} /> : <p>{t.loading}</p>}</div> : null}
    </div>
  );
}

function Facts({ report }: { readonly report: KernelReport }) {
  const text = t.kernel;
  const named = (names: readonly string[]) => (names.length === 0 ? text.nothing : names.map((name) => text.features[name] ?? name).join(", "));
  return (
    <>
      <p>{origin_of(report)}</p>
      <dl>
        <dt>{text.left_out}</dt>
        <dd data-fact="left-out">{named(report.leftOut)}</dd>
        <dt>{text.compiled_in}</dt>
        <dd data-fact="compiled-in">{named(report.compiledIn)}</dd>
      </dl>
      <p>{[report.emptyCells === undefined ? "" : text.empty(report.emptyCells), report.registers === undefined ? "" : text.registers(report.registers)].filter(Boolean).join(" ")}</p>
    </>
  );
}

function origin_of({ origin, fromCache, compileMilliseconds }: KernelReport): string {
  const text = t.kernel;
  if (origin === KernelOrigin.FOR_THIS_SCENE) return fromCache ? text.from_cache : text.for_this_scene(compileMilliseconds);
  return origin === KernelOrigin.GENERAL ? text.general : text.ahead_of_time;
}
