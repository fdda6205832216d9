import type { Area } from "../../../input/flat";
import type { Collaboration } from "../../../live/collaboration";
import { pointOf, type Placing } from "../../../slices/placing";
import { pixelOf, spotOf, type Stack } from "../../../slices/stack";
import { PointerMark } from "../../picture/pointer_mark";
import { nameOf } from "../share_dialog";

export interface SlicePointersProps {
  readonly collaboration: Collaboration;
  readonly stack: Stack;
  /** The shown slice. */
  readonly index: number;
  readonly placing: Placing;
  readonly area: Area;
}

/** The pointers of the other participants that lie in this slice. */
export function SlicePointers({ collaboration, stack, index, placing, area }: SlicePointersProps) {
  const here = [...collaboration.pointers.value.values()].filter(({ place }) => pixelOf(stack, place).slice === index);
  if (here.length === 0) return null;
  return (
    <div class="slice-pointers" aria-hidden="true">
      {here.map(({ number, place }) => (
        <PointerMark
          key={number}
          at={pointOf(stack, placing, area, spotOf(stack, place))}
          area={area}
          number={number}
          name={nameOf(collaboration.people.value, number)}
        />
      ))}
    </div>
  );
}
