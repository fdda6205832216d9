import { expect, test } from "vitest";
import { keep, kept } from "../kept";
import { hints_due, hints_seen } from "./hint_memory";

function some_store() {
  const items = new Map<string, string>();
  return () => ({ getItem: (key: string) => items.get(key) ?? null, setItem: (key: string, value: string) => void items.set(key, value) });
}
const blocked = () => {
  throw new DOMException("Access is denied for this document.", "SecurityError");
};

test("hints are shown once", () => {
  const store = some_store();
  expect(hints_due(store)).toBe(true);
  expect(hints_due(store)).toBe(true); // until they were seen to their end
  hints_seen(store);
  expect(hints_due(store)).toBe(false);
});

test("hints never come where nothing can be kept: blocked, full, or thrown away at once", () => {
  expect(hints_due(blocked)).toBe(false);
  expect(hints_seen(blocked)).toBe(false);
  const full = () => ({ getItem: () => null, setItem: () => { throw new DOMException("", "QuotaExceededError"); } });
  expect(hints_due(full)).toBe(false);
  expect(hints_due(() => ({ getItem: () => null, setItem: () => undefined }))).toBe(false);
});

test("what is kept is found again, and blocked storage is as an empty one", () => {
  const store = some_store();
  expect(keep("a", "b", store)).toBe(true);
  expect(kept("a", store)).toBe("b");
  expect(kept("a", blocked)).toBeNull();
});
