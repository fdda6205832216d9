import { keptPhases, sparserChoices, type PhaseChoice } from "../scan/keep_phases";
import type { Phases } from "../scan/types";
import { t } from "../texts";
import { Choice } from "./choice";

export interface PhasesFieldProps {
  readonly phases: Phases;
  readonly choice: PhaseChoice;
  readonly onChoose: (choice: PhaseChoice) => void;
  readonly disabled: boolean;
}

/** The choice of the phases to upload: all of them, fewer at equal distances, or a single one. */
export function PhasesField({ phases: { count }, choice, onChoose, disabled }: PhasesFieldProps) {
  const isOne = "only" in choice;
  return (
    <div class="series-phases">
      <Choice
        label={t.add.phasesToUpload}
        value={isOne ? "only" : `${choice.every}`}
        options={[
          ["1", t.add.allPhases(count)],
          ...sparserChoices(count).map(
            (every) => [`${every}`, t.add.everyPhase(every, keptPhases({ every }, count))] as const,
          ),
          ["only", t.add.onePhase],
        ]}
        onChoose={(value) => onChoose(value === "only" ? { only: 0 } : { every: Number(value) })}
        disabled={disabled}
      />
      {isOne ? (
        <Choice
          label={t.add.phaseNumber}
          value={`${choice.only}`}
          options={Array.from({ length: count }, (_, i) => [`${i}`, t.add.phaseOf(i + 1, count)] as const)}
          onChoose={(value) => onChoose({ only: Number(value) })}
          disabled={disabled}
        />
      ) : null}
    </div>
  );
}
