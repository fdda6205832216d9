import { PhaseKind, type Phase } from "../../scene/phases";
import { t } from "../../texts";

/** Returns the label of a phase, such as "35 %" or "b = 1000 s/mm²". */
export function phaseText(phases: readonly Phase[], index: number): string {
  const text = t.phases.labels;
  const { kind, value } = phases[index] ?? { kind: PhaseKind.INDEX, value: index };
  switch (kind) {
    case PhaseKind.TIME:
      return text.time(value);
    case PhaseKind.CYCLE:
      return text.cycle(value);
    case PhaseKind.ECHO:
      return text.echo(value);
    case PhaseKind.B_VALUE:
      return text.bValue(value);
    default:
      return text.index(index, phases.length);
  }
}
