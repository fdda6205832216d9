import type { Area } from "../../../input/flat";
import { scaleBar } from "../../../slices/scale_bar";
import { t } from "../../../texts";

/** Returns the maximum length of the scale bar in pixels: at most a third of a narrow pane. */
const longestBar = (area: Area): number => Math.min(160, area.width / 3);

export function ScaleBar({ pixelsPerMm, area }: { readonly pixelsPerMm: number; readonly area: Area }) {
  if (area.width === 0) return null;
  const { mm, pixels } = scaleBar(pixelsPerMm, longestBar(area));
  const text = mm < 10 ? t.slices.millimetres(mm) : t.slices.centimetres(mm / 10);
  return (
    <p class="slice-scale" style={{ width: `${pixels}px` }} role="img" aria-label={t.slices.scale(text)}>
      {text}
    </p>
  );
}
