import { useEffect, useState } from "preact/hooks";
import { t } from "../../texts";
import { curveFile, curveFormats, type CurveFormat } from "../../video/curve_file";
import type { ViewerSession } from "../../video/viewer_session";
import { ErrorPlot } from "./error_plot";
import { saveFile } from "./export/save_file";

/** Time for which a view must be shown before its curve is requested, because a gesture creates many views. */
const calmMs = 1000;

/** The curve of the error of the current picture, and buttons that save it. */
export function ErrorCurvePart({ session }: { readonly session: ViewerSession }) {
  const points = session.pictures.curve.value;
  const epoch = session.pictures.picture.value?.epoch;
  const finished = session.pictures.converged.value;
  const { phase } = session.connection.value;
  const [saving, setSaving] = useState(false);
  useEffect(() => {
    if (phase !== "live") return;
    const timer = setTimeout(() => void session.curve.refresh(), calmMs);
    return () => clearTimeout(timer);
  }, [epoch, finished, phase, session]);
  const save = async (format: CurveFormat) => {
    setSaving(true);
    await session.curve.refresh();
    setSaving(false);
    const { width = 0, height = 0 } = session.pictures.picture.value ?? {};
    saveFile(
      curveFile(format, session.pictures.curve.value, { width, height, device: t.kernel.device(session.device.value) }),
    );
  };
  return (
    <div class="error-curve">
      <ErrorPlot points={points} />
      <div class="error-curve-files" role="group" aria-label={t.curve.save}>
        <span class="muted">{t.curve.save}</span>
        {curveFormats.map((format) => (
          <button
            key={format}
            type="button"
            class="button button-small"
            aria-label={t.curve.saveAs(format.toUpperCase())}
            disabled={saving || points.length < 2}
            onClick={() => void save(format)}
          >
            {format.toUpperCase()}
          </button>
        ))}
      </div>
    </div>
  );
}
