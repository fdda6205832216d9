import { within_bounds, type Viewport } from "../../../protocol/messages";
import { longest_large_side } from "../../../video/file_shot";
import { longest_side, shortest_side } from "../../../video/still_shot";

const large_side = 2048;
const poster_side = 8192;

/** Of the shape that is on the screen, larger or smaller. */
export const with_longest_side = (screen: Viewport, longest: number): Viewport => {
  const grown = longest / Math.max(screen.width, screen.height, 1);
  return within_bounds({ width: screen.width * grown, height: screen.height * grown }, longest);
};

export const large = (screen: Viewport): Viewport => with_longest_side(screen, large_side);
export const largest = (screen: Viewport): Viewport => with_longest_side(screen, longest_side);
export const poster = (screen: Viewport): Viewport => with_longest_side(screen, poster_side);

/** The page itself holds no more; larger ones a worker makes, in bands of rows. */
export const is_held_by_page = ({ width, height }: Viewport): boolean => Math.max(width, height) <= longest_side;

/** Two sides as they were typed; nothing where they are no whole numbers within the bounds. */
export function typed_size(width: string, height: string): Viewport | null {
  const side = (text: string) => (/^\d{1,6}$/.test(text.trim()) ? Number(text) : 0);
  const size = { width: side(width), height: side(height) };
  return [size.width, size.height].every((n) => n >= shortest_side && n <= longest_large_side) ? size : null;
}
