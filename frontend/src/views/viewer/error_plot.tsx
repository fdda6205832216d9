import { t } from "../../texts";
import { plotOf } from "../../video/plot_scale";
import type { ErrorPoint } from "../../video/picture_facts";
import { percentExactText } from "../format";

const width = 190;
const height = 74;

export function ErrorPlot({ points }: { readonly points: readonly ErrorPoint[] }) {
  const plot = plotOf(points, width, height);
  return (
    <svg class="plot" viewBox={`-2 -6 ${width + 38} ${height + 12}`} role="img" aria-label={t.viewer.plot}>
      <rect class="plot-frame" x={0} y={0} width={width} height={height} rx={4} />
      {plot?.vertical.map((x) => (
        <line key={`v${x}`} class="plot-grid" x1={x} x2={x} y1={0} y2={height} />
      ))}
      {plot?.horizontal.map(({ at, percent }) => (
        <g key={percent}>
          <line class="plot-grid" x1={0} x2={width} y1={at} y2={at} />
          <text class="plot-label" x={width + 4} y={at + 3}>
            {percentExactText(percent / 100)}
          </text>
        </g>
      ))}
      {plot ? <polyline class="plot-line" points={plot.line} /> : null}
    </svg>
  );
}
