/** What can honestly be said of a new password before it is sent. Which are common is for the server to say. */

/** In characters, as people count them; the server has the same. */
export const shortestPassword = 12;

export interface Strength {
  /** 0 too short or all alike, 1 enough, 2 good, 3 very good. */
  readonly level: 0 | 1 | 2 | 3;
  /** How many characters are missing; 0 when it is long enough. */
  readonly missing: number;
}

/** Length is what counts; characters that only repeat count as one. */
export function strengthOf(password: string): Strength {
  const characters = Array.from(password);
  const missing = Math.max(0, shortestPassword - characters.length);
  const turns = characters.filter((one, i) => one !== characters[i - 1]).length;
  const distinct = new Set(characters).size;
  const worth = Math.min(turns, distinct * 3);
  if (missing > 0 || worth < shortestPassword / 2) return { level: 0, missing };
  return { level: worth >= 20 ? 3 : worth >= 16 ? 2 : 1, missing };
}
