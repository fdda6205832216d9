import { expect, it } from "vitest";
import { keeping, type Browsers } from "./storage";

const refused = (): never => {
  throw new DOMException("The operation is insecure.", "SecurityError");
};
function made(): Browsers {
  const values = new Map<string, string>();
  return {
    getItem: (key) => values.get(key) ?? null,
    setItem: (key, value) => void values.set(key, value),
    removeItem: (key) => void values.delete(key),
    clear: () => values.clear(),
  };
}

it("keeps values until the page closes if the browser blocks storage or it is full", () => {
  for (const browsers of [
    refused,
    () => ({ ...made(), setItem: refused }),
    () => ({ ...made(), setItem: () => undefined }),
    () => null as unknown as Storage,
  ]) {
    const store = keeping(browsers);
    expect(store.getItem("a")).toBeNull();
    store.setItem("a", "1");
    expect(store.keep("b", "2")).toBe(false);
    expect(store.getItem("a")).toBe("1");
    store.removeItem("a");
    expect([store.getItem("a"), store.getItem("b")]).toEqual([null, "2"]);
    store.clear();
    expect(store.getItem("b")).toBeNull();
  }
});

it("uses the browser's storage where it is available", () => {
  const own = made();
  const store = keeping(() => own);
  store.setItem("a", "1");
  expect(own.getItem("a")).toBe("1");
  store.removeItem("a");
  expect(own.getItem("a")).toBeNull();
  own.setItem("b", "2");
  expect(store.getItem("b")).toBe("2");
  expect(store.keep("c", "3")).toBe(true);
  expect(own.getItem("c")).toBe("3");
});
