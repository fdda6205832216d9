import { percentExactText, plainNumberText } from "../views/format";
import { t } from "../texts";
import type { ErrorPoint } from "./picture_facts";
import { plotOf, type Plot } from "./plot_scale";

export const curveFormats = ["csv", "json", "svg"] as const;
export type CurveFormat = (typeof curveFormats)[number];

/** The size of the rendered picture, and the device that rendered it. */
export interface CurveSource {
  readonly width: number;
  readonly height: number;
  readonly device: string;
}

const writers: Record<CurveFormat, { readonly type: string; readonly write: typeof csvOf }> = {
  csv: { type: "text/csv", write: csvOf },
  json: { type: "application/json", write: jsonOf },
  svg: { type: "image/svg+xml", write: svgOf },
};

/** Returns the curve as a file that explains its numbers. Nothing in it identifies the scan. */
export function curveFile(format: CurveFormat, points: readonly ErrorPoint[], source: CurveSource): Blob {
  const { type, write } = writers[format];
  return new Blob([write(points, source)], { type });
}

/** Returns the sentences that every format contains. */
const headerOf = ({ width, height, device }: CurveSource): string[] => {
  const { title, samples, seconds, error, guide, source } = t.curve.file;
  return [title, samples, seconds, error, guide, source(width, height, device)];
};

export function csvOf(points: readonly ErrorPoint[], source: CurveSource): string {
  const rows = points.map(({ samples, seconds, error }) => [samples, seconds, error].join(","));
  return [...headerOf(source).map((line) => `# ${line}`), "samples,seconds,error", ...rows, ""].join("\n");
}

export function jsonOf(points: readonly ErrorPoint[], source: CurveSource): string {
  const units = {
    samples: "samples per pixel",
    seconds: "s of rendering time",
    error: "relative RMSE, 1 = black to white",
  };
  const document = {
    format: "diaphane-error-curve",
    version: 1,
    about: headerOf(source),
    units,
    ...source,
    points,
  };
  return `${JSON.stringify(document, null, 2)}\n`;
}

const size = { width: 640, height: 440 };
const box = { x: 78, y: 76, width: 530, height: 290 };

const escaped = (text: string): string =>
  text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;").replaceAll('"', "&quot;");
const textAt = (x: number, y: number, anchor: string, words: string, more = ""): string =>
  `<text x="${x.toFixed(1)}" y="${y.toFixed(1)}" text-anchor="${anchor}"${more}>${escaped(words)}</text>`;
const lineAt = (x1: number, y1: number, x2: number, y2: number): string =>
  `<line x1="${x1.toFixed(1)}" y1="${y1.toFixed(1)}" x2="${x2.toFixed(1)}" y2="${y2.toFixed(1)}" stroke="#ccc"/>`;

export function svgOf(points: readonly ErrorPoint[], source: CurveSource): string {
  const plot = plotOf(points, box.width, box.height);
  const about = headerOf(source);
  return [
    `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${size.width} ${size.height}" font-family="sans-serif" font-size="12" fill="#222">`,
    `<title>${escaped(about[0] ?? "")}</title>`,
    `<desc>${escaped(about.join(" "))}</desc>`,
    `<rect width="${size.width}" height="${size.height}" fill="#fff"/>`,
    textAt(box.x, 24, "start", about[0] ?? "", ' font-size="15"'),
    textAt(box.x, 42, "start", t.curve.file.source(source.width, source.height, source.device), ' fill="#555"'),
    ...axes(plot),
    `<g transform="translate(${box.x} ${box.y})" fill="none">`,
    `<polyline points="${plot?.guide ?? ""}" stroke="#888" stroke-width="1.5" stroke-dasharray="6 4"/>`,
    `<polyline points="${plot?.line ?? ""}" stroke="#0b62c4" stroke-width="2" stroke-linejoin="round"/>`,
    `<rect width="${box.width}" height="${box.height}" stroke="#222"/>`,
    "</g>",
    `<line x1="${box.x}" y1="424" x2="${box.x + 28}" y2="424" stroke="#888" stroke-width="1.5" stroke-dasharray="6 4"/>`,
    textAt(box.x + 36, 428, "start", t.curve.guide),
    "</svg>",
    "",
  ].join("\n");
}

/** Draws the grid, the numbers at its lines and the titles of the axes. */
function axes(plot: Plot | null): string[] {
  const right = box.x + box.width,
    bottom = box.y + box.height;
  const middle = box.y + box.height / 2;
  return [
    ...(plot?.vertical ?? []).flatMap(({ at, seconds }) => [
      lineAt(box.x + at, box.y, box.x + at, bottom),
      textAt(box.x + at, bottom + 17, "middle", plainNumberText(seconds)),
    ]),
    ...(plot?.horizontal ?? []).flatMap(({ at, percent }) => [
      lineAt(box.x, box.y + at, right, box.y + at),
      textAt(box.x - 8, box.y + at + 4, "end", percentExactText(percent / 100)),
    ]),
    ...(plot?.samples ?? []).flatMap(({ at, samples }) => [
      lineAt(box.x + at, box.y - 5, box.x + at, box.y),
      textAt(box.x + at, box.y - 8, "middle", plainNumberText(samples)),
    ]),
    textAt(right, box.y - 22, "end", t.curve.samplesAxis, ' fill="#555"'),
    textAt(box.x + box.width / 2, bottom + 37, "middle", t.curve.timeAxis),
    textAt(0, 0, "middle", t.curve.errorAxis, ` transform="translate(22 ${middle}) rotate(-90)"`),
  ];
}
