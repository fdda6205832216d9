import { describe, expect, it } from "vitest";
import { applyGraphKey, graphKeyAction, type GraphKeyAction } from "./graph_keys";

const stroke = (key: string, more: Partial<Parameters<typeof graphKeyAction>[0]> = {}) => ({
  key,
  shiftKey: false,
  ctrlKey: false,
  metaKey: false,
  altKey: false,
  ...more,
});

describe("graphKeyAction", () => {
  it("moves by a two-hundredth of the shown values, and with Shift ten times as far", () => {
    expect(graphKeyAction(stroke("ArrowRight"), 2000)).toEqual({ kind: "move", value: 10, opacity: 0 });
    expect(graphKeyAction(stroke("ArrowLeft", { shiftKey: true }), 2000)).toEqual({
      kind: "move",
      value: -100,
      opacity: 0,
    });
    expect(graphKeyAction(stroke("ArrowUp"), 2000)).toEqual({ kind: "move", value: 0, opacity: 0.01 });
  });

  it("moves by at least one value, however narrow the range is", () => {
    expect(graphKeyAction(stroke("ArrowRight"), 3)).toMatchObject({ value: 1 });
  });

  it("ignores the browser's shortcuts and other keys", () => {
    for (const modifier of ["ctrlKey", "metaKey", "altKey"] as const)
      expect(graphKeyAction(stroke("ArrowRight", { [modifier]: true }), 2000)).toBeNull();
    expect(graphKeyAction(stroke("Tab"), 2000)).toBeNull();
  });
});

describe("applyGraphKey", () => {
  const apply = (action: GraphKeyAction, point: number) => {
    const calls: string[] = [];
    applyGraphKey(action, { value: 55, opacity: 0.75 }, 3, {
      point,
      range: { low: 0, high: 100 },
      choose: (to) => calls.push(`choose ${to}`),
      move: (which, value, opacity, held) => calls.push(`move ${which} ${value} ${opacity} ${held}`),
      rest: () => calls.push("rest"),
      remove: () => calls.push("remove"),
      add: () => calls.push("add"),
    });
    return calls;
  };

  it("stops at the first and at the last point", () => {
    expect(apply({ kind: "choose", by: -1 }, 0)).toEqual(["choose 0"]);
    expect(apply({ kind: "choose", by: 1 }, 1)).toEqual(["choose 2"]);
    expect(apply({ kind: "choose", by: 1 }, 2)).toEqual(["choose 2"]);
  });

  it("moves the chosen point from where it is", () => {
    expect(apply({ kind: "move", value: 5, opacity: -0.25 }, 1)).toEqual(["move 1 60 0.5 false"]);
  });

  it("adds and removes points", () => {
    expect(apply({ kind: "add" }, 1)).toEqual(["add"]);
    expect(apply({ kind: "remove" }, 1)).toEqual(["remove"]);
  });
});
