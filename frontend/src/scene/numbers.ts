export interface Limits {
  readonly low: number;
  readonly high: number;
}

export const clamp = (value: number, low: number, high: number): number => Math.min(high, Math.max(low, value));

/** What is no number stays what it was. */
export const within = (value: number, { low, high }: Limits, otherwise: number): number =>
  Number.isFinite(value) ? clamp(value, low, high) : otherwise;

export const degrees = (radians: number): number => (radians * 180) / Math.PI;
export const radians = (angle: number): number => (angle * Math.PI) / 180;

/** A copy with another at `index`. */
export const replaced = <Item>(items: readonly Item[], index: number, item: Item): Item[] =>
  items.map((one, i) => (i === index ? item : one));
export const without = <Item>(items: readonly Item[], index: number): Item[] => items.filter((_, i) => i !== index);

/**
 * What a person typed: a number within the limits, or nothing. A decimal comma is one, too; what merely begins as a number
 * is none.
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

/** As short as it may be said: whole from a thousand on, else so many significant digits and no zeros behind. */
export const shortNumber = (value: number, digits = 4): string => {
  const rounded = Math.abs(value) >= 1000 ? Math.round(value) : Number(value.toPrecision(digits));
  return Object.is(rounded, -0) ? "0" : String(rounded);
};
