import { describe, expect, it } from "vitest";
import { closedLayout, docked, moved, opened, placeIn, rememberLayout, rememberedLayout } from "./layout";

const screen = { width: 1000, height: 600 };

describe("the settings windows", () => {
  it("replace a docked window by a newly opened one, and keep free ones", () => {
    const one = opened(closedLayout, "look", false);
    expect(opened(one, "light", false).open).toEqual(["light"]);
    const free = moved(one, "look", 300, 100, screen);
    expect(opened(free, "light", false).open).toEqual(["look", "light"]);
    expect(docked(opened(free, "light", false), "look").open).toEqual(["look"]);
  });

  it("show one sheet at a time", () => {
    const free = moved(opened(closedLayout, "look", false), "look", 300, 100, screen);
    expect(opened(free, "lens", true).open).toEqual(["lens"]);
  });

  it("always stay within reach", () => {
    for (const [x, y] of [
      [-1e6, -1e6],
      [1e6, 1e6],
      [-1, 700],
    ] as const) {
      const place = placeIn(moved(closedLayout, "light", x, y, screen), "light");
      expect(!place.docked && place.x >= 0 && place.x <= 920 && place.y >= 0 && place.y <= 552).toBe(true);
    }
  });

  it("keep their layout after a reload", () => {
    const kept = new Map<string, string>();
    const store = {
      getItem: (name: string) => kept.get(name) ?? null,
      setItem: (name: string, value: string) => void kept.set(name, value),
    };
    const layout = moved(opened(closedLayout, "cuts", false), "cuts", 20, 30, screen);
    rememberLayout(store, layout);
    expect(rememberedLayout(store)).toEqual(layout);
    for (const text of ["{", "7", '{"open":["wings",3],"places":{"look":{"x":"far"}}}']) {
      kept.set("diaphane.windows", text);
      expect(rememberedLayout(store)).toEqual(closedLayout);
    }
  });
});
