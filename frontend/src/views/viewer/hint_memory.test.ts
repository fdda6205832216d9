import { expect, test } from "vitest";
import { keeping } from "../../storage";
import { hintsDue, hintsSeen } from "./hint_memory";

function made() {
  const items = new Map<string, string>();
  return {
    getItem: (key: string) => items.get(key) ?? null,
    setItem: (key: string, value: string) => void items.set(key, value),
    removeItem: () => undefined,
    clear: () => undefined,
  };
}

test("hints are shown once", () => {
  const browsers = made();
  const store = keeping(() => browsers);
  expect(hintsDue(store)).toBe(true);
  expect(hintsDue(store)).toBe(true); // until they were seen to their end
  hintsSeen(store);
  expect(hintsDue(store)).toBe(false);
});

test("hints are not shown if the browser cannot store that they were shown", () => {
  const blocked = () => {
    throw new DOMException("Access is denied for this document.", "SecurityError");
  };
  const full = () => ({ ...made(), setItem: blocked });
  for (const browsers of [blocked, full, () => ({ ...made(), setItem: () => undefined })]) {
    const store = keeping(browsers);
    expect(hintsDue(store)).toBe(false);
    expect(hintsSeen(store)).toBe(false);
  }
});
