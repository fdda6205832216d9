import { typedNumber, type Limits } from "../../../scene/numbers";
import { numberText } from "../../format";

export interface TypedProps {
  readonly label: string;
  readonly title?: string;
  readonly value: number;
  readonly limits: Limits;
  readonly take: (value: number) => void;
}

/** A field for a number. An invalid number is replaced by the previous one. */
export function Typed({ label, title, value, limits, take }: TypedProps) {
  return (
    <label class="slice-typed" title={title}>
      <span>{label}</span>
      <input
        type="text"
        inputMode="decimal"
        autocomplete="off"
        maxLength={12}
        value={numberText(value)}
        onFocus={(event) => event.currentTarget.select()}
        onKeyDown={(event) => {
          if (event.key === "Enter") event.currentTarget.blur();
        }}
        onBlur={(event) => {
          const typed = typedNumber(event.currentTarget.value, limits);
          event.currentTarget.value = numberText(typed ?? value);
          if (typed !== null && typed !== value) take(typed);
        }}
      />
    </label>
  );
}
