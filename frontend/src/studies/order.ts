import type { Step } from "./definition";
import { randomNumbers, shuffled } from "./random";

/**
 * Returns the steps as a participant gets them: consecutive steps of one group in random order, all others in place.
 */
export function orderedSteps(steps: readonly Step[], seed: number): Step[] {
  const result: Step[] = [];
  for (let begin = 0; begin < steps.length;) {
    const group = steps[begin]?.group ?? "";
    let end = begin + 1;
    while (group !== "" && steps[end]?.group === group) end += 1;
    const run = steps.slice(begin, end);
    result.push(...(run.length > 1 ? shuffled(run, randomNumbers(seed, `order/${group}/${begin}`)) : run));
    begin = end;
  }
  return result;
}

/** Returns a copy of the list with one item moved. The item stays within the list. */
export function moved<Item>(items: readonly Item[], from: number, to: number): Item[] {
  const item = items[from];
  if (item === undefined) return [...items];
  const rest = items.filter((_, i) => i !== from);
  const at = Math.max(0, Math.min(rest.length, to));
  return [...rest.slice(0, at), item, ...rest.slice(at)];
}
