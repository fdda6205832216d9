import { expect, test } from "vitest";
import { keeping } from "../../storage";
import { hints_due, hints_seen } from "./hint_memory";

function made() {
  const items = new Map<string, string>();
  return { getItem: (key: string) => items.get(key) ?? null, setItem: (key: string, value: string) => void items.set(key, value), removeItem: () => undefined, clear: () => undefined };
}

test("hints are shown once", () => {
  const browsers = made();
  const store = keeping(() => browsers);
  expect(hints_due(store)).toBe(true);
  expect(hints_due(store)).toBe(true); // until they were seen to their end
  hints_seen(store);
  expect(hints_due(store)).toBe(false);
});

test("hints never come where nothing can be kept: blocked, full, or thrown away at once", () => {
  const blocked = () => {
    throw new DOMException("Access is denied for this document.", "SecurityError");
  };
  const full = () => ({ ...made(), setItem: blocked });
  for (const browsers of [blocked, full, () => ({ ...made(), setItem: () => undefined })]) {
    const store = keeping(browsers);
    expect(hints_due(store)).toBe(false);
    expect(hints_seen(store)).toBe(false);
  }
});
