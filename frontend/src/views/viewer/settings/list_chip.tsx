import type { Rgb } from "../../../protocol/gen/api/proto/scene_pb";
import { hexOf } from "../../../scene/colour";

interface ListChipProps {
  readonly name: string;
  readonly colour: Rgb | undefined;
  readonly chosen: boolean;
  readonly choose: () => void;
  readonly on: boolean;
  readonly turn: (on: boolean) => void;
  /** Label of the checkbox. */
  readonly turnLabel: string;
}

/** An entry of a list of lights or materials: a checkbox that turns it on or off, and a button that chooses it. */
export function ListChip({ name, colour, chosen, choose, on, turn, turnLabel }: ListChipProps) {
  return (
    <>
      <input
        type="checkbox"
        aria-label={turnLabel}
        checked={on}
        onChange={(event) => turn(event.currentTarget.checked)}
      />
      <button type="button" aria-pressed={chosen} onClick={choose}>
        <svg class="swatch" viewBox="0 0 10 10" aria-hidden="true">
          <circle cx="5" cy="5" r="4.500" fill={hexOf(colour)} />
        </svg>
        {name}
      </button>
    </>
  );
}
