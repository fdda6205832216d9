import { signal } from "@preact/signals";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { vec3 } from "../input/vec3";
import { rgb } from "../scene/colour";
import { someScene } from "../scene/testing";
import { slicesFromText, slicesToText } from "./memory";
import { noSources } from "./sources";
import { Slices } from "./model";
import type { WantedSlice } from "./store";
import { placeOf } from "./stack";
import { axial, coronal, header, sagittal } from "./testing";

describe("the slices of a scan", () => {
  let asked: (readonly WantedSlice[])[] = [];
  let frames: FrameRequestCallback[] = [];
  beforeEach(() => {
    asked = [];
    frames = [];
    vi.stubGlobal("requestAnimationFrame", (task: FrameRequestCallback) => frames.push(task));
  });
  afterEach(() => vi.unstubAllGlobals());
  const frame = () => {
    for (const task of frames.splice(0)) task(0);
    return asked.at(-1)?.map(({ plane, index }) => `${plane} ${index}`);
  };
  const begun = () => {
    const slices = new Slices((lacking) => asked.push(lacking));
    slices.configured([axial, sagittal, coronal], header);
    slices.allow("whole");
    return slices;
  };

  it("are requested only while they are visible", () => {
    const slices = begun();
    expect(frame()).toBeUndefined();
    slices.open.value = true;
    expect(frame()).toEqual(["axial 2", "sagittal 3", "coronal 2"]);
    slices.maximise("coronal");
    slices.scroll(coronal, 1);
    expect(frame()).toEqual(["coronal 3"]);
    slices.maximise("coronal");
    expect(slices.view.value).toBe("four");
  });
  it("all contain the crosshair", () => {
    const slices = begun();
    slices.pointAt(axial, vec3(-0.6, 0.8, 100));
    expect([axial, sagittal, coronal].map((stack) => slices.index(stack))).toEqual([4, 2, 2]);
    slices.step(axial, 1, -1);
    expect([axial, sagittal, coronal].map((stack) => slices.index(stack))).toEqual([4, 3, 1]);
  });
  it("are shown one at a time on a narrow page, without requesting the picture behind them", () => {
    const slices = begun();
    slices.narrow.value = true;
    slices.open.value = true;
    expect(slices.view.value).toBe("axial");
    expect(slices.pictureShown.value).toBe(false);
    slices.shown.value = "picture";
    expect(slices.pictureShown.value).toBe(true);
  });
  it("are as before a reload of the same volume, with their measurements", () => {
    const slices = begun();
    slices.open.value = true;
    slices.goTo(axial, 0);
    slices.setWindow({ centre: 1, width: 2 });
    const ruler = { kind: "ruler", plane: "axial", slice: 0, points: [vec3(0, 0, -6), vec3(2, 0, -6)] } as const;
    const ellipse = { ...ruler, kind: "ellipse" } as const;
    slices.measures.value = [ruler, ellipse, { ...ruler, points: [vec3(0, 0, -6)] }];
    slices.smooth.value = false;
    slices.overlay.value = { shown: true, strength: 0.25 };
    const remembered = slicesFromText(slicesToText(slices.remembered() ?? expect.unreachable()));

    const again = new Slices(() => undefined, remembered);
    again.configured([axial, sagittal, coronal], header);
    again.allow("whole");
    expect(again.view.value).toBe("four");
    expect(again.index(axial)).toBe(0);
    expect(again.window.value).toEqual({ centre: 1, width: 2 });
    expect(again.measures.value).toEqual([ruler, ellipse]); // the other one was not finished
    expect(again.smooth.value).toBe(false);
    expect(again.overlay.value).toEqual({ shown: true, strength: 0.25 });

    const other = new Slices(() => undefined, remembered);
    other.configured([axial, sagittal, coronal], { ...header, contentHash: "another" });
    expect(other.measures.value).toEqual([]);
    expect(other.open.value).toBe(false);
  });
  it("let a guest on a narrow page choose only among the views that are presented", () => {
    const guest = new Slices(() => undefined);
    guest.configured([axial, sagittal, coronal], header);
    guest.narrow.value = true;
    guest.allow("shown");
    const presented = begun().presented();
    guest.follow({ ...presented, view: "four" });
    expect(guest.choosable.value).toBe(true);
    guest.follow({ ...presented, view: "coronal" });
    expect(guest.choosable.value).toBe(false);
    guest.allow("clipped");
    expect(guest.choosable.value).toBe(true);
  });
  it("begin with the presenter's window where the range of the values is unknown", () => {
    const presented = { ...begun().presented(), window: { centre: 103, width: 205 } };
    const guest = (told: object) => {
      const slices = new Slices(() => undefined);
      slices.configured([axial, sagittal, coronal], {
        ...header,
        contentHash: "",
        windowWidth: 0,
        maximum: 3034,
        ...told,
      });
      slices.allow("whole");
      return slices;
    };
    const unknown = guest({});
    unknown.follow(presented);
    expect(unknown.window.value).toEqual(presented.window);
    expect(unknown.following.value).toBe(false);
    // A window of their own stays, and a reset returns to the presenter's.
    unknown.setWindow({ centre: 1, width: 2 });
    unknown.follow({ ...presented, window: { centre: 50, width: 60 } });
    expect(unknown.window.value).toEqual({ centre: 1, width: 2 });
    unknown.reset();
    expect(unknown.window.value).toEqual({ centre: 50, width: 60 });
    const known = guest({ windowCenter: 40, windowWidth: 400 });
    known.follow(presented);
    expect(known.window.value).toEqual({ centre: 40, width: 400 });
  });
  it("are smooth and grey if nothing else was kept", () => {
    const old = '{"volume":"a","crosshair":{"x":0,"y":0,"z":0},"window":{"centre":1,"width":2},"measures":[]}';
    expect(slicesFromText(old)).toMatchObject({ smooth: true, overlay: { shown: false, strength: 0.5 } });
  });
  it("move a measurement by its handle within its slice only", () => {
    const slices = begun();
    slices.goTo(axial, 1);
    const ruler = { kind: "ruler", plane: "axial", slice: 1, points: [vec3(0, 0, -3), vec3(2, 0, -3)] } as const;
    slices.measures.value = [ruler];
    expect(slices.hold(axial, vec3(1, 0, -3), 0.5)).toBe(false);
    expect(slices.hold(axial, vec3(1.9, 0, -3), 0.5)).toBe(true);
    slices.moveHeld(axial, vec3(2, 1, -3));
    expect(slices.measures.value).toEqual([{ ...ruler, points: [vec3(0, 0, -3), vec3(2, 1, -3)] }]);
    slices.scroll(axial, 1);
    slices.moveHeld(axial, vec3(9, 9, 0));
    expect(slices.measures.value[0]?.points[1]).toEqual(vec3(2, 1, -3));
    slices.measures.value = [ruler, { ...ruler, points: [vec3(0, 0, -3)] }];
    slices.goTo(axial, 1);
    expect(slices.hold(axial, vec3(2, 0, -3), 0.5)).toBe(false); // an unfinished one comes first
  });
  it("have the look's colours if they are shown, also after the look has changed", () => {
    const look = signal(someScene().transferFunction ?? null);
    const slices = new Slices(() => undefined, null, { ...noSources, look: () => look.value });
    slices.configured([axial, sagittal, coronal], header);
    const red = () => (slices.table.value[55] ?? 0) & 255;
    const blue = () => ((slices.table.value[55] ?? 0) >> 16) & 255;
    expect(red()).toBe(blue());
    slices.overlay.value = { shown: true, strength: 1 };
    const muscle = look.value?.channels[0] ?? expect.unreachable();
    expect(red()).toBeGreaterThan(blue() + 50);
    look.value = { ...(look.value ?? expect.unreachable()), channels: [{ ...muscle, diffuse: rgb(0, 0, 1) }] };
    expect(blue()).toBeGreaterThan(red() + 50);
  });
  it("begin again if what was kept is damaged", () => {
    for (const text of [null, "{", "[]", '{"volume":"a"}', '{"volume":"a","crosshair":{"x":"1"},"measures":[]}'])
      expect(slicesFromText(text)).toBeNull();
  });
  it("survive a reconnection, and are reset for another volume", () => {
    const slices = begun();
    expect(slices.window.value).toEqual({ centre: 40, width: 400 });
    slices.setWindow({ centre: 1, width: 2 });
    slices.goTo(axial, 0);
    slices.configured([axial, sagittal, coronal], header);
    expect(slices.window.value).toEqual({ centre: 1, width: 2 });
    expect(slices.index(axial)).toBe(0);
    slices.configured([axial, sagittal, coronal], { ...header, contentHash: "b" });
    expect(slices.window.value).toEqual({ centre: 40, width: 400 });
    expect(slices.index(axial)).toBe(2);
  });
  it("are neither requested nor shown without permission", () => {
    const slices = new Slices((lacking) => asked.push(lacking));
    slices.configured([axial, sagittal, coronal], header);
    slices.open.value = true;
    expect(slices.available.value).toBe(false);
    expect(slices.view.value).toBe("picture");
    expect(frame()).toBeUndefined();
    slices.allow("clipped");
    expect(slices.view.value).toBe("four");
    expect(frame()).toEqual(["axial 2", "sagittal 3", "coronal 2"]);
    slices.allow("none");
    expect(slices.open.value).toBe(false);
    expect(slices.view.value).toBe("picture");
  });
  it("are requested again after the clip has changed", () => {
    const slices = begun();
    slices.open.value = true;
    frame();
    asked = [];
    slices.stale();
    expect(frame()).toEqual(["axial 2", "sagittal 3", "coronal 2"]);
  });
  it("are shown to viewers who do not get the volume's hash", () => {
    const slices = new Slices((lacking) => asked.push(lacking));
    slices.configured([axial, sagittal, coronal], { ...header, contentHash: "" });
    slices.allow("clipped");
    expect(slices.available.value).toBe(true);
    slices.setWindow({ centre: 1, width: 2 });
    slices.configured([axial, sagittal, coronal], { ...header, contentHash: "" });
    expect(slices.window.value).toEqual({ centre: 1, width: 2 });
  });

  it("can be tilted about the crosshair, which the server is asked for by geometry", () => {
    const slices = begun();
    slices.open.value = true;
    slices.turn("axial", 30);
    expect(frame()).toEqual([
      expect.stringContaining("axial"),
      expect.stringContaining("sagittal"),
      expect.stringContaining("coronal"),
    ]);
    const [first] = asked.at(-1) ?? [];
    expect(first?.oblique).toBeGreaterThan(0);
    expect(first?.stack).toBe(slices.stacks.value.get("axial"));
    const id = first?.oblique;
    slices.turn("axial", 1);
    frame();
    expect(asked.at(-1)?.[0]?.oblique, "another direction is another slice").not.toBe(id);
    slices.straighten();
    expect(slices.stacks.value).toBe(slices.straight.value);
  });

  it("keep the place in their view when they are tilted or become thick, and are straight after a reset", () => {
    const slices = begun();
    slices.place(axial, { zoom: 3, column: axial.columns - 1, row: 1 });
    const middle = () => {
      const stack = slices.stacks.value.get("axial") ?? axial;
      const { column, row } = slices.placing(stack);
      return placeOf(stack, { column, row, slice: slices.index(stack) });
    };
    const before = middle();
    slices.setSlab({ mm: 500, projection: "maximum" });
    expect(slices.slab.value.mm, "at most 100 mm").toBe(100);
    expect(middle().x).toBeCloseTo(before.x);
    expect(middle().y).toBeCloseTo(before.y);
    slices.turn("axial", 10); // keeps the axial plane
    expect(middle().x).toBeCloseTo(before.x);
    slices.reset();
    expect(slices.slab.value.mm).toBe(0);
    expect(slices.stacks.value).toBe(slices.straight.value);
  });

  it("keep their tilt and slab across a reload and for followers, who return to their own", () => {
    const slices = begun();
    slices.open.value = true;
    slices.turn("coronal", 20);
    slices.setSlab({ mm: 5, projection: "minimum" });
    const stored = slicesFromText(slicesToText(slices.remembered() as never));
    const again = new Slices(() => undefined, stored);
    again.configured([axial, sagittal, coronal], header);
    again.allow("whole");
    expect(again.tilt.value).toEqual(slices.tilt.value);
    expect(again.slab.value).toEqual(slices.slab.value);
    slices.labels.value = { shown: true, strength: 0.75 };
    const follower = begun();
    follower.follow(slices.presented());
    expect(follower.labels.value.shown, "the presenter's scan has no labels").toBe(false);
    expect(follower.tilt.value).toEqual(slices.tilt.value);
    expect(follower.slab.value).toEqual(slices.slab.value);
    follower.unfollow();
    expect(follower.tilt.value).toBeNull();
    expect(follower.slab.value.mm).toBe(0);
  });

  it("measure in space while they are tilted", () => {
    const slices = begun();
    slices.turn("axial", 25);
    const stack = slices.stacks.value.get("coronal") ?? coronal;
    const place = (column: number) => placeOf(stack, { column, row: 8, slice: slices.index(stack) });
    slices.setPoint(stack, "ruler", place(5));
    slices.setPoint(stack, "ruler", place(9));
    expect(slices.measures.value).toMatchObject([{ plane: null, kind: "ruler" }]);
    expect(slices.hold(stack, place(9), 0.5)).toBe(true);
    slices.moveHeld(stack, place(7));
    expect(slices.measures.value[0]?.points[1]).toEqual(place(7));
    slices.scroll(stack, 1);
    expect(slices.hold(stack, place(5), 0.5), "it lies in the other slice").toBe(false);
  });
});
