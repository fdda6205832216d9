import { describe, expect, it } from "vitest";
import { heights, outline } from "./histogram";
import { hex_of, hue_of, rgb, rgb_of, with_hue } from "./colour";
import { short_number, typed_number } from "./numbers";
import { reset_part } from "./parts";
import { some_scene } from "./testing";
import { add_channel, add_point, channels_of, move_point, opacity_at, point_limits, remove_channel, remove_point, roomiest_value, set_material, shifted, shown_range, transfer_of } from "./transfer";

const values = (scene = some_scene(), channel = 1) => channels_of(scene)[channel]?.opacity.map((p) => p.value);

describe("points of a channel", () => {
  it("never pass each other, however far they are dragged", () => {
    const far = move_point(some_scene(), 1, 1, { value: 99_999, opacity: 7 });
    expect(values(far)).toEqual([180, 3071, 3072]);
    expect(channels_of(far)[1]?.opacity[1]?.opacity).toBe(1);
    expect(values(move_point(some_scene(), 1, 1, { value: -99_999 }))).toEqual([180, 181, 3072]);
  });

  it("where they stand closer than a value, they keep their order", () => {
    const close = shifted(transfer_of(some_scene()), 0);
    const points = [0, 0.25, 0.5].map((value, i) => ({ ...(close.channels[0]?.opacity[i] ?? { $typeName: "diaphane.v1.OpacityPoint" as const, opacity: 0 }), value }));
    const scene = { ...some_scene(), transferFunction: { ...close, channels: close.channels.map((c, i) => (i === 0 ? { ...c, opacity: points } : c)) } };
    const moved = values(move_point(scene, 0, 1, { value: 50 }), 0) ?? [];
    expect(moved[1]).toBeGreaterThan(0.25);
    expect(moved[1]).toBeLessThan(0.5);
  });

  it("are added on the curve and taken away again, and two always stay", () => {
    const scene = some_scene();
    const added = add_point(scene, 1, 300);
    expect(added?.index).toBe(1);
    expect(added && channels_of(added.scene)[1]?.opacity[1]?.opacity).toBeCloseTo(0.5, 12);
    expect(added && channels_of(remove_point(added.scene, 1, 1))).toEqual(channels_of(scene));
    const two = remove_point(scene, 1, 0);
    expect(remove_point(two, 1, 0)).toBe(two);
  });

  it("are not added where there is one, or where no number is", () => {
    for (const value of [180, 180.4, NaN, Infinity, 1e12]) expect(add_point(some_scene(), 1, value)).toBeNull();
  });

  it("beyond the ends a channel is closed, within it is a line", () => {
    const [, bone] = channels_of(some_scene());
    expect(bone && [179.9, 180, 300, 420, 3072, 3073].map((v) => Number(opacity_at(bone, v).toFixed(6)))).toEqual([0, 0, 0.5, 1, 1, 0]);
    expect(bone && roomiest_value(bone)).toBe(1746);
  });

  it("have limits that a person can be told", () => {
    const [muscle] = channels_of(some_scene());
    expect(muscle && point_limits(muscle, 1)).toEqual({ low: 6, high: 259 });
  });
});

describe("the whole function", () => {
  it("shifts by as much, and back again", () => {
    const transfer = transfer_of(some_scene());
    expect(shifted(shifted(transfer, 123), -123)).toEqual(transfer);
    expect(shifted(transfer, 100).channels[1]?.opacity[0]?.value).toBe(280);
  });

  it("keeps a channel, and adds them in colours of their own", () => {
    let scene = some_scene();
    for (let i = 0; i < 100; i++) scene = add_channel(scene, "new", { low: -1000, high: 3000 });
    expect(channels_of(scene).length).toBe(64);
    for (let i = 0; i < 100; i++) scene = remove_channel(scene, 0);
    expect(channels_of(scene).length).toBe(1);
  });

  it("is shown with all of its points and all of the volume's values", () => {
    expect(shown_range(transfer_of(some_scene()), -1024, 2000)).toEqual({ low: -1024, high: 3072 });
  });

  it("comes back as it was by the reset of its part, and nothing else with it", () => {
    const begun = some_scene();
    const changed = { ...set_material(begun, 0, { name: "flesh", disabled: true }), bounces: 4 };
    const back = reset_part(changed, begun, "look");
    expect(back.transferFunction).toBe(begun.transferFunction);
    expect(back.bounces).toBe(4);
    expect(reset_part({ ...changed, clip: { $typeName: "diaphane.v1.Clip", planes: [], cutsLight: true } }, begun, "cuts").clip).toBeUndefined();
  });
});

describe("the histogram", () => {
  it("air does not press all else to the ground, where heights are even", () => {
    expect(heights([1_000_000, 10, 5, 0], false)).toEqual([1, 1, 0.5, 0]);
    expect(heights([0, 0], false)).toEqual([0, 0]);
    expect(heights([], true)).toEqual([]);
    const log = heights([999_999, 999, 0], true);
    expect(log[1]).toBeCloseTo(0.5, 3);
  });

  it("stands where its values are, also when more than them is shown", () => {
    const line = outline({ minimum: 0, width: 10, counts: [4, 2] }, { low: -20, high: 80 }, 100, 50, true);
    expect(line.split(" ")[0]).toBe("20.0,50");
    expect(line.split(" ").at(-1)).toBe("40.0,50");
  });
});

describe("what a person types", () => {
  const limits = { low: -10, high: 100 };
  it("is a number within the limits, or nothing", () => {
    expect(["5", " 7,5 ", "\u22123", "1e1", ".5", "100"].map((text) => typed_number(text, limits))).toEqual([5, 7.5, -3, 10, 0.5, 100]);
    for (const text of ["", " ", "5 mm", "0x10", "NaN", "Infinity", "1,2,3", "101", "-11", "1e9", "--5", "five"]) expect(typed_number(text, limits)).toBeNull();
  });

  it("is said back shortly", () => {
    expect([0.1 + 0.2, -0.00001, 12345.678, 300, -0].map((n) => short_number(n))).toEqual(["0.3", "-0.00001", "12346", "300", "0"]);
  });
});

describe("a colour", () => {
  it("is on the screen what it was chosen as", () => {
    for (const hex of ["#000000", "#ffffff", "#0c6a73", "#010203", "#fe8040"]) expect(hex_of(rgb_of(hex))).toBe(hex);
    expect(hex_of(rgb(40, 20, 0))).toBe("#ffff00");
  });

  it("of a light keeps its strength when its hue changes", () => {
    const red = with_hue(rgb(40, 38, 36), rgb(1, 0, 0));
    expect([red.r, red.g, red.b]).toEqual([40, 0, 0]);
    expect(hue_of(rgb(0, 0, 0))).toEqual(rgb(1, 1, 1));
  });
});
