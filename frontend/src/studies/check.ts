import { cameraOf, sceneFromJson } from "../protocol/messages";
import { hasView, studyLanguages, type Definition, type Step, type Text, type View } from "./definition";
import { isOffTarget } from "./views";

/** Limits of the server. */
export const limits = {
  title: 120,
  text: 2000,
  words: 2000,
  places: 1000,
  steps: 100,
  materials: 8,
  pictures: 10,
  options: 20,
  delays: 20,
  delayMs: 400,
  rating: 100,
  studyPictures: 20,
  daysAhead: 365,
  bytes: 1024 * 1024,
} as const;

/** What is missing or wrong, as a key of the texts. */
export type StudyProblem =
  | "title"
  | "titleLong"
  | "places"
  | "end"
  | "large"
  | "steps"
  | "text"
  | "textLong"
  | "view"
  | "labels"
  | "start"
  | "region"
  | "regionName"
  | "regionAtTarget"
  | "scale"
  | "materials"
  | "pictures"
  | "studyPictures"
  | "options"
  | "delays";

export interface Finding {
  readonly problem: StudyProblem;
  /** The ID of the step, or null if the study as a whole is meant. */
  readonly step: string | null;
}

const isThere = (text: Text): boolean => studyLanguages.some((one) => (text[one] ?? "").trim() !== "");
const isWithin = (text: Text, most: number): boolean => studyLanguages.every((one) => (text[one] ?? "").length <= most);
const isName = (text: Text, most: number): boolean => isThere(text) && isWithin(text, most);
const isWhole = (value: number, low: number, high: number): boolean =>
  Number.isInteger(value) && value >= low && value <= high;

/** Returns everything that keeps a study from being saved, in the order of the page. */
export function findingsOf(definition: Definition, nowMs: number): Finding[] {
  const found: Finding[] = definition.steps.flatMap((step) =>
    problemsOf(step).map((problem) => ({ problem, step: step.id })),
  );
  return [...wholeProblems(definition, nowMs).map((problem) => ({ problem, step: null })), ...found];
}

function wholeProblems(definition: Definition, nowMs: number): StudyProblem[] {
  const { title, places, steps } = definition;
  const end = Date.parse(definition.ends_at);
  const pictures = steps.reduce((sum, step) => sum + (step.kind === "order" ? step.pictures.length : 0), 0);
  const isEndWrong = !(end > nowMs) || end > nowMs + limits.daysAhead * 86_400_000;
  const bytes = new TextEncoder().encode(JSON.stringify(definition)).length;
  return [
    ...when(!isThere(title), "title"),
    ...when(!isWithin(title, limits.title), "titleLong"),
    ...when(!isWhole(places, 1, limits.places), "places"),
    ...when(isEndWrong, "end"),
    ...when(steps.length < 2 || steps.length > limits.steps, "steps"),
    ...when(pictures > limits.studyPictures, "studyPictures"),
    ...when(bytes > limits.bytes, "large"),
  ];
}

const when = (wrong: boolean, problem: StudyProblem): StudyProblem[] => (wrong ? [problem] : []);

function problemsOf(step: Step): StudyProblem[] {
  const view = hasView(step) ? step.view : undefined;
  return [
    ...when(!isThere(step.text), "text"),
    ...when(!isWithin(step.text, limits.text), "textLong"),
    ...when(hasView(step) && step.kind !== "rating" && !view, "view"),
    ...when(view?.region !== undefined && !isName(view.region.name, limits.title), "regionName"),
    ...ofKind(step),
  ];
}

function ofKind(step: Step): StudyProblem[] {
  switch (step.kind) {
    case "rating":
      return [
        ...when(!isWhole(step.low, 0, limits.rating) || !isWhole(step.high, step.low + 1, limits.rating), "scale"),
        ...when(!isName(step.low_text, limits.text) || !isName(step.high_text, limits.text), "labels"),
      ];
    case "colours":
      return when(
        step.materials.length < 1 ||
          step.materials.length > limits.materials ||
          !step.materials.every((m) => isName(m.name, limits.title)),
        "materials",
      );
    case "order":
      return when(step.pictures.length < 2 || step.pictures.length > limits.pictures, "pictures");
    case "choice":
      return when(
        step.options.length < 2 ||
          step.options.length > limits.options ||
          !step.options.every((o) => isName(o.text, limits.text)),
        "options",
      );
    case "latency":
      return [
        ...when(step.view !== undefined && !step.view.region, "region"),
        ...when(step.view !== undefined && step.view.start !== "random", "start"),
        ...regionAtTarget(step.view),
        ...delays(step.delays_ms),
      ];
    default:
      return [];
  }
}

const delays = (all: readonly number[]): StudyProblem[] =>
  when(all.length < 1 || all.length > limits.delays || !all.every((one) => isWhole(one, 0, limits.delayMs)), "delays");

function regionAtTarget(view: View | undefined): StudyProblem[] {
  if (!view?.region) return [];
  const scene = sceneFromJson(JSON.stringify(view.scene));
  const target = scene && cameraOf(scene)?.target;
  return when(target !== null && target !== undefined && !isOffTarget(view.region, target), "regionAtTarget");
}

/** Reads delays such as "0, 50 100". Returns null if one of them is not allowed. */
export function delaysFrom(text: string): readonly number[] | null {
  const all = text
    .split(/[\s,;]+/)
    .filter(Boolean)
    .map(Number);
  return delays(all).length === 0 ? all : null;
}
