import { describe, expect, it } from "vitest";
import { length, subtract } from "../input/vec3";
import { cameraOf } from "../protocol/messages";
import {
  addPlane,
  boxOf,
  cutsLight,
  faceLimits,
  moveFace,
  movePlane,
  planesOf,
  setAlone,
  setCutsLight,
  setSlice,
} from "./cuts";
import { focusOf, heightAtTarget, isOrthographic, setFocus, setFov, setOrthographic } from "./lens";
import { resetPart } from "./parts";
import { someBounds, someScene } from "./testing";
import { withCamera } from "../protocol/messages";

const grey = { centre: 300, width: 1500 };

describe("the box", () => {
  it("goes as far as requested, and is absent when the whole is kept", () => {
    const cut = moveFace(someScene(), someBounds, "x", "high", 10);
    expect(boxOf(cut, someBounds).high).toEqual({ ...someBounds.high, x: 10 });
    const whole = moveFace(cut, someBounds, "x", "high", 500);
    expect([whole.clip?.boxLow, whole.clip?.boxHigh]).toEqual([undefined, undefined]);
  });

  it("its faces never pass each other", () => {
    const cut = moveFace(someScene(), someBounds, "z", "high", -50);
    expect(faceLimits(cut, someBounds, "z", "low")).toEqual({ low: -80, high: -51 });
    expect(boxOf(moveFace(cut, someBounds, "z", "low", 70), someBounds).low.z).toBe(-51);
  });
});

describe("light", () => {
  it("falls on what a new cut lays open, until that is said otherwise", () => {
    const cut = moveFace(someScene(), someBounds, "y", "low", 0);
    expect(cut.clip?.cutsLight).toBe(true);
    expect(addPlane(someScene()).clip?.cutsLight).toBe(true);
    expect(cutsLight(moveFace(setCutsLight(cut, false), someBounds, "y", "low", 10))).toBe(false);
  });
});

describe("a plane", () => {
  it("begins in front and cuts the patient's front away", () => {
    const plane = addPlane(someScene()).clip?.planes[0];
    expect(plane?.normal?.y).toBeCloseTo(-1, 12);
  });

  it("is told back as it was set", () => {
    const scene = movePlane(addPlane(someScene()), someBounds, 0, { right: 40, up: -25, offset: 33 });
    const [plane] = planesOf(scene);
    expect([plane?.right, plane?.up, plane?.offset].map((n) => Number(n?.toFixed(6)))).toEqual([40, -25, 33]);
  });

  it("there are six at most", () => {
    let scene = someScene();
    for (let i = 0; i < 9; i++) scene = addPlane(scene);
    expect(planesOf(scene).length).toBe(6);
  });
});

describe("slices", () => {
  it("have the scan's own grey from the first on", () => {
    const scene = setSlice(someScene(), someBounds, grey, "axial", { shown: true });
    expect([scene.slices?.windowCentre, scene.slices?.windowWidth]).toEqual([300, 1500]);
  });

  it("are alone only while there is one: the last one that goes brings the matter back", () => {
    const alone = setAlone(setSlice(someScene(), someBounds, grey, "axial", { shown: true }), grey, true);
    expect(alone.slices?.alone).toBe(true);
    expect(setSlice(alone, someBounds, grey, "axial", { shown: false }).slices?.alone).toBe(false);
    expect(setAlone(someScene(), grey, true).slices?.alone).toBe(false);
  });
});

describe("the lens", () => {
  const height = (scene = someScene()) => {
    const pose = cameraOf(scene);
    return pose ? heightAtTarget(pose) : 0;
  };
  it("at any field of view the middle stays as large", () => {
    for (const fov of [5, 15, 60, 100]) expect(height(setFov(someScene(), fov))).toBeCloseTo(height(), 6);
  });

  it("parallel rays show the middle as large, and zooming zooms them", () => {
    const parallel = setOrthographic(someScene(), true);
    expect(parallel.camera?.orthographicHeight).toBeCloseTo(height(), 9);
    const pose = cameraOf(parallel);
    if (!pose) throw new Error("no camera");
    const nearer = withCamera(parallel, { ...pose, eye: { x: 0, y: -250, z: 30 } });
    expect(nearer.camera?.orthographicHeight).toBeCloseTo(height() / 2, 9);
    expect(isOrthographic(setOrthographic(nearer, false))).toBe(false);
  });

  it("is sharp at the middle until told otherwise", () => {
    const pose = cameraOf(someScene());
    const distance = pose ? length(subtract(pose.eye, pose.target)) : 0;
    expect(focusOf(someScene())).toEqual({ distance, middle: true });
    expect(focusOf(setFocus(someScene(), 300))).toEqual({ distance: 300, middle: false });
    expect(focusOf(setFocus(setFocus(someScene(), 300), null)).middle).toBe(true);
  });

  it("stays when the eye moves, and comes back without moving the eye", () => {
    const scene = setFocus(someScene(), 300);
    const pose = cameraOf(scene);
    if (!pose) throw new Error("no camera");
    const moved = withCamera(scene, { ...pose, eye: { x: 100, y: -400, z: 0 } });
    expect(moved.camera?.focalDistance).toBe(300);
    const back = resetPart(moved, someScene(), "lens");
    expect([back.camera?.focalDistance, back.camera?.eye?.x]).toEqual([0, 100]);
  });
});
