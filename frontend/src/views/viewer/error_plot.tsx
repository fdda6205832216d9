import { t } from "../../texts";
import { plotOf } from "../../video/plot_scale";
import type { ErrorPoint } from "../../video/picture_facts";
import { percentExactText, plainNumberText } from "../format";

const width = 190;
const height = 74;

/** The error against rendering time, with the slope that it has in theory. A saved SVG draws the same curve. */
export function ErrorPlot({ points }: { readonly points: readonly ErrorPoint[] }) {
  const plot = plotOf(points, width, height);
  return (
    <svg class="plot" viewBox={`-2 -6 ${width + 38} ${height + 34}`} role="img" aria-label={t.viewer.plot}>
      <rect class="plot-frame" x={0} y={0} width={width} height={height} rx={4} />
      {plot?.vertical.map(({ at, seconds }) => (
        <g key={seconds}>
          <line class="plot-grid" x1={at} x2={at} y1={0} y2={height} />
          <text class="plot-label" x={at} y={height + 11} text-anchor="middle">
            {plainNumberText(seconds)}
          </text>
        </g>
      ))}
      {plot?.horizontal.map(({ at, percent }) => (
        <g key={percent}>
          <line class="plot-grid" x1={0} x2={width} y1={at} y2={at} />
          <text class="plot-label" x={width + 4} y={at + 3}>
            {percentExactText(percent / 100)}
          </text>
        </g>
      ))}
      {plot ? null : (
        <text class="plot-label" x={width / 2} y={height / 2 + 3} text-anchor="middle">
          {t.viewer.errorUnknown}
        </text>
      )}
      {plot ? <polyline class="plot-guide" points={plot.guide} /> : null}
      {plot ? <polyline class="plot-line" points={plot.line} /> : null}
      <text class="plot-label" x={width / 2} y={height + 23} text-anchor="middle">
        {t.curve.timeAxis}
      </text>
    </svg>
  );
}
