/** An estimate of the strength of a new password before it is sent. Only the server knows the common ones. */

/** The minimum length in characters as users count them, like the server's limit. */
export const shortestPassword = 12;

export interface Strength {
  /** 0: too short or too repetitive. 1: long enough. 2: good. 3: very good. */
  readonly level: 0 | 1 | 2 | 3;
  /** Number of missing characters, or 0 if the password is long enough. */
  readonly missing: number;
}

/** Estimates the strength by the length alone, in which repeated characters count as one. */
export function strengthOf(password: string): Strength {
  const characters = Array.from(password);
  const missing = Math.max(0, shortestPassword - characters.length);
  const turns = characters.filter((one, i) => one !== characters[i - 1]).length;
  const distinct = new Set(characters).size;
  const worth = Math.min(turns, distinct * 3);
  if (missing > 0 || worth < shortestPassword / 2) return { level: 0, missing };
  return { level: worth >= 20 ? 3 : worth >= 16 ? 2 : 1, missing };
}
