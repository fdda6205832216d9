export interface Limits {
  readonly low: number;
  readonly high: number;
}

export const clamp = (value: number, low: number, high: number): number => Math.min(high, Math.max(low, value));

/** Limits a value, or returns `otherwise` if it is not a number. */
export const within = (value: number, { low, high }: Limits, otherwise: number): number =>
  Number.isFinite(value) ? clamp(value, low, high) : otherwise;

export const degrees = (radians: number): number => (radians * 180) / Math.PI;
export const radians = (angle: number): number => (angle * Math.PI) / 180;

/** Returns a copy with another item at `index`. */
export const replaced = <Item>(items: readonly Item[], index: number, item: Item): Item[] =>
  items.map((one, i) => (i === index ? item : one));
export const without = <Item>(items: readonly Item[], index: number): Item[] => items.filter((_, i) => i !== index);

/**
 * Parses a number that the user typed. Accepts a decimal comma. Returns null if the text is not a number within the
 * limits.
 */
export function typedNumber(text: string, { low, high }: Limits): number | null {
  const plain = text
    .trim()
    .replace(",", ".")
    .replace(/^\u2212/, "-");
  if (!/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain)) return null;
  const value = Number(plain);
  return value >= low && value <= high ? value : null;
}

/**
 * Formats a number as briefly as possible: rounded to an integer if it is 1000 or more, else with
 * this many significant digits and no trailing zeros.
 */
export const shortNumber = (value: number, digits = 4): string => {
  const rounded = Math.abs(value) >= 1000 ? Math.round(value) : Number(value.toPrecision(digits));
  return Object.is(rounded, -0) ? "0" : String(rounded);
};
