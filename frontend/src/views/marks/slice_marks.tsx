import type { Area, Point } from "../../input/flat";
import type { Marks } from "../../marks/marks";
import { placeInSlice, viewOfSlice } from "../../marks/view";
import type { Placing } from "../../slices/placing";
import type { Stack } from "../../slices/stack";
import { MarkHandles } from "./mark_handles";
import { MarkMaker } from "./mark_maker";
import { MarkShapes } from "./mark_shapes";

export interface SliceMarksProps {
  readonly marks: Marks;
  readonly number: number;
  readonly stack: Stack;
  /** The shown slice. */
  readonly index: number;
  readonly placing: Placing;
  readonly area: Area;
}

/** The marks on and near a slice. */
export function SliceMarks({ marks, number, stack, index, placing, area }: SliceMarksProps) {
  if (!marks.editing.value && marks.items.value.length + marks.others.value.size === 0) return null;
  const view = viewOfSlice(stack, placing, area, index);
  const locate = (at: Point) => Promise.resolve(placeInSlice(stack, placing, area, index, at));
  return (
    <div class="slice-pointers">
      <svg width={area.width} height={area.height} aria-hidden="true">
        <MarkShapes marks={marks} number={number} view={view} area={area} />
      </svg>
      <MarkHandles marks={marks} number={number} view={view} locate={locate} />
      <MarkMaker marks={marks} view={view} area={area} locate={locate} focused={false} />
    </div>
  );
}
