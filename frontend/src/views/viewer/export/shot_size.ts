import { withinBounds, type Viewport } from "../../../protocol/messages";
import { longestLargeSide } from "../../../video/file_shot";
import { longestSide, shortestSide } from "../../../video/still_shot";

const largeSide = 2048;
const posterSide = 8192;

/** Returns a size with the shape of the screen and this longest side. */
export const withLongestSide = (screen: Viewport, longest: number): Viewport => {
  const grown = longest / Math.max(screen.width, screen.height, 1);
  return withinBounds({ width: screen.width * grown, height: screen.height * grown }, longest);
};

export const large = (screen: Viewport): Viewport => withLongestSide(screen, largeSide);
export const largest = (screen: Viewport): Viewport => withLongestSide(screen, longestSide);
export const poster = (screen: Viewport): Viewport => withLongestSide(screen, posterSide);

/** Whether the page itself can hold the picture. A worker creates larger ones in bands of rows. */
export const isHeldByPage = ({ width, height }: Viewport): boolean => Math.max(width, height) <= longestSide;

/** Parses the two sides. Returns null if they are not whole numbers within the limits. */
export function typedSize(width: string, height: string): Viewport | null {
  const side = (text: string) => (/^\d{1,6}$/.test(text.trim()) ? Number(text) : 0);
  const size = { width: side(width), height: side(height) };
  return [size.width, size.height].every((n) => n >= shortestSide && n <= longestLargeSide) ? size : null;
}
