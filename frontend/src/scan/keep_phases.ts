import { withVolumes } from "./image/canonical";
import type { Series, UploadPlan } from "./types";
import { partsOf, planOf } from "./upload_plan";

/** Which phases of a series are uploaded: each `every`th one, or only the one with the index `only`. */
export type PhaseChoice = { readonly every: number } | { readonly only: number };

export const allPhases: PhaseChoice = { every: 1 };

const phaseCount = ({ verdict }: Series): number => (verdict.suitable ? (verdict.phases?.count ?? 1) : 1);

/**
 * Whether phases can be left out. They can't if a file contains slices of several phases, because files of DICOM are
 * sent as a whole.
 */
export const hasChoice = (series: Series): boolean => {
  const count = phaseCount(series);
  return count > 1 && series.upload.files.length === (series.upload.isOneFile ? count : count * series.slices);
};

/** Returns the number of phases that a choice keeps of `count`. */
export const keptPhases = (choice: PhaseChoice, count: number): number =>
  "only" in choice ? 1 : Math.ceil(count / choice.every);

/** Returns the choices of each second, third, fourth, fifth and tenth phase that leave at least two. */
export const sparserChoices = (count: number): readonly number[] =>
  [2, 3, 4, 5, 10].filter((every) => Math.ceil(count / every) >= 2);

/** Returns a series of which only the chosen phases are uploaded. Its parts are in the order of the phases. */
export function keepPhases(series: Series, choice: PhaseChoice): Series {
  const count = phaseCount(series);
  if (!hasChoice(series) || ("every" in choice && choice.every === 1)) return series;
  const isKept = (phase: number) => ("only" in choice ? phase === choice.only : phase % choice.every === 0);
  const name = "only" in choice ? `only${choice.only}` : `every${choice.every}`;
  // The same files with another choice are another upload, even if it has the same length.
  return {
    ...series,
    upload: sparser(series.upload, count, isKept, choice),
    fingerprint: `${series.fingerprint} ${name}`,
  };
}

function sparser(plan: UploadPlan, count: number, isKept: (phase: number) => boolean, choice: PhaseChoice): UploadPlan {
  const parts = partsOf(plan);
  const kept = parts.filter((_, i) => isKept(Math.floor((i * count) / parts.length)));
  if (!plan.isOneFile) return planOf(kept);
  const every = "only" in choice ? 1 : choice.every;
  const head = withVolumes(parts[0]?.head ?? new Uint8Array(), kept.length, every);
  return planOf(
    kept.map((part, i) => ({ ...part, head: i === 0 ? head : new Uint8Array() })),
    true,
  );
}
