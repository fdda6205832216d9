/** The definition of a study (docs/contracts.md, "Studies"), as the server stores it. */

export const studyLanguages = ["en", "de"] as const;
export type StudyLanguage = (typeof studyLanguages)[number];

/** A text for participants, in at least one language. */
export type Text = Readonly<Partial<Record<StudyLanguage, string>>>;

export const templates = ["comfort", "validation", "viewpoints", "latency", "sus", "own"] as const;
export type Template = (typeof templates)[number];

export type MayChange = "camera" | "colours" | "lights";
export const mayChangeParts: readonly MayChange[] = ["camera", "colours", "lights"];

export type Numbers = readonly [number, number, number];

/** A sphere in world space. */
export interface Region {
  readonly name: Text;
  readonly centre: Numbers;
  /** In mm. */
  readonly radius: number;
}

/** What a step shows. */
export interface View {
  readonly data_set_id: string;
  /** A scene in Protobuf's JSON format. */
  readonly scene: object;
  /** The name of the look, for the researcher. */
  readonly preset: string;
  readonly may_change: readonly MayChange[];
  readonly start: "preset" | "random";
  readonly region?: Region;
}

interface StepBase {
  readonly id: string;
  /** Consecutive steps of one group are shown in random order. Empty for no group. */
  readonly group: string;
  readonly text: Text;
}

export interface PlainStep extends StepBase {
  readonly kind: "consent" | "text" | "words";
}
export interface RatingStep extends StepBase {
  readonly kind: "rating";
  readonly view?: View;
  readonly low: number;
  readonly high: number;
  readonly low_text: Text;
  readonly high_text: Text;
}
export interface Material {
  /** The name of the channel of the transfer function. */
  readonly channel: string;
  readonly name: Text;
}
export interface ColoursStep extends StepBase {
  readonly kind: "colours";
  readonly view?: View;
  readonly materials: readonly Material[];
}
export interface StudyPicture {
  readonly id: string;
  readonly comfort: number;
}
export interface OrderStep extends StepBase {
  readonly kind: "order";
  readonly pictures: readonly StudyPicture[];
}
export interface ViewpointStep extends StepBase {
  readonly kind: "viewpoint";
  readonly view?: View;
}
export interface Option {
  readonly id: string;
  readonly text: Text;
}
export interface ChoiceStep extends StepBase {
  readonly kind: "choice";
  readonly options: readonly Option[];
  readonly multiple: boolean;
}
export interface LatencyStep extends StepBase {
  readonly kind: "latency";
  readonly view?: View;
  readonly delays_ms: readonly number[];
}

export type Step = PlainStep | RatingStep | ColoursStep | OrderStep | ViewpointStep | ChoiceStep | LatencyStep;
export type StepKind = Step["kind"];
/** The steps with a live picture. */
export type ViewStep = RatingStep | ColoursStep | ViewpointStep | LatencyStep;

export const stepKinds: readonly StepKind[] = [
  "text",
  "rating",
  "colours",
  "order",
  "viewpoint",
  "choice",
  "words",
  "latency",
];

export interface Definition {
  readonly version: 1;
  readonly template: Template;
  readonly title: Text;
  readonly places: number;
  /** RFC 3339. */
  readonly ends_at: string;
  /** Whether participants may agree to a recording of how they move the picture. */
  readonly record: boolean;
  readonly steps: readonly Step[];
}

/** The answer to a step, by its kind. */
export type Answer =
  | Readonly<Record<string, never>>
  | { readonly rating: number }
  | { readonly colours: readonly { readonly channel: string; readonly from: string; readonly to: string }[] }
  | { readonly order: readonly string[]; readonly shown: readonly string[] }
  | { readonly camera: CameraValue; readonly start: CameraValue }
  | { readonly choice: readonly string[] }
  | { readonly words: string }
  | { readonly trials: readonly Trial[] };

export interface CameraValue {
  readonly eye: Numbers;
  readonly target: Numbers;
  readonly up: Numbers;
}

export interface Trial {
  readonly delay_ms: number;
  readonly time_ms: number;
  readonly error_degrees: number;
  readonly acceptable: boolean;
  readonly rating: number;
}

export const hasView = (step: Step): step is ViewStep =>
  step.kind === "rating" || step.kind === "colours" || step.kind === "viewpoint" || step.kind === "latency";

/** Returns a text in a language, or else in the other one, with the language that it is in. */
export function textIn(text: Text, language: StudyLanguage): { readonly text: string; readonly lang: StudyLanguage } {
  const lang = [language, ...studyLanguages].find((one) => (text[one] ?? "").trim() !== "") ?? language;
  return { text: text[lang] ?? "", lang };
}

/** Returns a copy of a text with one language changed. An empty text removes the language. */
export function withText(text: Text, language: StudyLanguage, value: string): Text {
  const all = studyLanguages.map((one) => [one, one === language ? value : (text[one] ?? "")] as const);
  return Object.fromEntries(all.filter(([, words]) => words !== ""));
}

/** Returns an ID that no step has yet, such as "rating-2". */
export function freeId(taken: readonly string[], stem: string): string {
  if (!taken.includes(stem)) return stem;
  for (let number = 2; ; ++number) if (!taken.includes(`${stem}-${number}`)) return `${stem}-${number}`;
}
