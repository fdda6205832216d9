/** What ingest changed in a scan or skipped. The server stores one English sentence per correction, with its figures. */
export type Correction =
  | "tilt"
  | "spacing"
  | "missing"
  | "duplicates"
  | "overview"
  | "size"
  | "damaged"
  | "brightness"
  | "negative"
  | "scaled"
  | "directions"
  | "phases";

/** Words that only the sentence of this correction contains (ingest/dicom/classify.cpp). The first match counts. */
const patterns: readonly (readonly [Correction, RegExp])[] = [
  ["phases", /phases? /i],
  ["tilt", /gantry tilt/i],
  ["missing", /missing/i],
  ["duplicates", /twice|duplicate/i],
  ["overview", /scout|overview|localizer/i],
  ["damaged", /damaged/i],
  ["size", /(another|different) size/i],
  ["brightness", /scale/i],
  ["scaled", /multiplied/i],
  ["negative", /negative/i],
  ["directions", /orientation/i],
  ["spacing", /slice to slice|spacing|distance/i],
];

/** Returns the kinds of these corrections, each once. An unknown sentence has no kind. */
export function correctionsOf(sentences: readonly string[]): Correction[] {
  const found = sentences.flatMap((sentence) => patterns.find(([, pattern]) => pattern.test(sentence))?.[0] ?? []);
  return [...new Set(found)];
}

/** One correction with its figures, for the details of a card. */
export type Note =
  | { readonly kind: "tilt"; readonly degrees: number }
  | { readonly kind: "spacing"; readonly fromMm: number; readonly toMm: number; readonly usedMm: number }
  | { readonly kind: "positions"; readonly mm: number }
  | {
      readonly kind: "missing" | "duplicates" | "overview" | "size" | "damaged" | "incomplete" | "uncommon";
      readonly count: number;
    }
  | { readonly kind: "fewer"; readonly kept: number; readonly of: number }
  | { readonly kind: "clipped"; readonly limit: number }
  | { readonly kind: "scaled"; readonly factor: number }
  | { readonly kind: "brightness" | "negative" | "halved" | "directions" };

type Figures = readonly number[];

const counted =
  (kind: Extract<Note, { readonly count: number }>["kind"]) =>
  ([count = 0]: Figures): Note => ({ kind, count });

/** The sentences of ingest, current ones and those of older scans, with their figures in order. */
const notes: readonly (readonly [RegExp, (figures: Figures) => Note])[] = [
  [/^(?:gantry tilt of|straightened) ([\d.]+) degrees /, ([degrees = 0]) => ({ kind: "tilt", degrees })],
  [
    /^(?:slice spacing varied|the distance from slice to slice varies) from ([\d.]+) to ([\d.]+) mm(?: and was resampled to|; slices were computed every) ([\d.]+) mm/,
    ([fromMm = 0, toMm = 0, usedMm = 0]) => ({ kind: "spacing", fromMm, toMm, usedMm }),
  ],
  [/^(?:slice positions deviated by|slices lie) up to ([\d.]+) mm/, ([mm = 0]) => ({ kind: "positions", mm })],
  [/^(\d+) slices? (?:was|were) missing /, counted("missing")],
  [/^(\d+) slices? (?:was|were) (?:duplicated|there twice);/, counted("duplicates")],
  [/^(\d+) (?:overview images?|scout pictures?) (?:was|were) /, counted("overview")],
  [/^(\d+) slices? of (?:a different|another) size (?:was|were) /, counted("size")],
  [/^(\d+) phases? (?:was|were) incomplete /, counted("incomplete")],
  [/^(\d+) slices? at the ends of some phases /, counted("uncommon")],
  [/^only (\d+) of (\d+) phases /, ([kept = 0, of = 0]) => ({ kind: "fewer", kept, of })],
  [/^(\d+) files? (?:was|were) damaged /, counted("damaged")],
  [/^values above ([\d,]+)(?: Hounsfield units)? were clipped$/, ([limit = 0]) => ({ kind: "clipped", limit })],
  [/^values were halved for storage$/, () => ({ kind: "halved" })],
  [/^values were multiplied by ([\d.e+-]+) for storage$/, ([factor = 1]) => ({ kind: "scaled", factor })],
  [/^the file does not specify its orientation/, () => ({ kind: "directions" })],
  [/^(?:the slices had different value scales|each slice had a scale of its own)/, () => ({ kind: "brightness" })],
  [/^the (?:inverted \(negative\) image was converted back|negative was inverted)$/, () => ({ kind: "negative" })],
];

/** Returns the correction that a sentence states, or null for an unknown sentence. */
export function noteOf(sentence: string): Note | null {
  for (const [pattern, make] of notes) {
    const found = pattern.exec(sentence);
    if (found) return make(found.slice(1).map((figure) => Number(figure.replaceAll(",", ""))));
  }
  return null;
}
