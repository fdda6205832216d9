import type { Area, Point } from "../../input/flat";

/** Number of colours of pointers. Participants with higher numbers reuse them. */
const colours = 8;
export const colourOf = (number: number): number => number % colours;

export interface PointerMarkProps {
  readonly at: Point;
  readonly area: Area;
  readonly number: number;
  readonly name: string;
}

/** The width in pixels that a name may need. */
const nameWidth = 150;

/** The pointer of a participant, with their name. */
export function PointerMark({ at, area, number, name }: PointerMarkProps) {
  return (
    <div
      class="pointer"
      data-pointer={number}
      data-colour={colourOf(number)}
      data-side={at.x > area.width - nameWidth ? "left" : "right"}
      style={{ transform: `translate(${at.x}px, ${at.y}px)` }}
    >
      <span>{name}</span>
    </div>
  );
}
