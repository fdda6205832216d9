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
  it("has the requested size, and is absent when it is the whole volume", () => {
    const cut = moveFace(someScene(), someBounds, "x", "high", 10);
    expect(boxOf(cut, someBounds).high).toEqual({ ...someBounds.high, x: 10 });
    const whole = moveFace(cut, someBounds, "x", "high", 500);
    expect([whole.clip?.boxLow, whole.clip?.boxHigh]).toEqual([undefined, undefined]);
  });

  it("has faces that never pass each other", () => {
    const cut = moveFace(someScene(), someBounds, "z", "high", -50);
    expect(faceLimits(cut, someBounds, "z", "low")).toEqual({ low: -80, high: -51 });
    expect(boxOf(moveFace(cut, someBounds, "z", "low", 70), someBounds).low.z).toBe(-51);
  });
});

describe("light", () => {
  it("passes through a new cut until that is turned off", () => {
    const cut = moveFace(someScene(), someBounds, "y", "low", 0);
    expect(cut.clip?.cutsLight).toBe(true);
    expect(addPlane(someScene()).clip?.cutsLight).toBe(true);
    expect(cutsLight(moveFace(setCutsLight(cut, false), someBounds, "y", "low", 10))).toBe(false);
  });
});

describe("a plane", () => {
  it("starts in front and cuts away the patient's front", () => {
    const plane = addPlane(someScene()).clip?.planes[0];
    expect(plane?.normal?.y).toBeCloseTo(-1, 12);
  });

  it("reads back as it was set", () => {
    const scene = movePlane(addPlane(someScene()), someBounds, 0, { right: 40, up: -25, offset: 33 });
    const [plane] = planesOf(scene);
    expect([plane?.right, plane?.up, plane?.offset].map((n) => Number(n?.toFixed(6)))).toEqual([40, -25, 33]);
  });

  it("is one of at most six", () => {
    let scene = someScene();
    for (let i = 0; i < 9; i++) scene = addPlane(scene);
    expect(planesOf(scene).length).toBe(6);
  });
});

describe("slices", () => {
  it("have the scan's own grey window from the start", () => {
    const scene = setSlice(someScene(), someBounds, grey, "axial", { shown: true });
    expect([scene.slices?.windowCentre, scene.slices?.windowWidth]).toEqual([300, 1500]);
  });

  it("are shown alone only while there is one, and the matter returns with the last one's removal", () => {
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
  it("keeps the size of the target at every field of view", () => {
    for (const fov of [5, 15, 60, 100]) expect(height(setFov(someScene(), fov))).toBeCloseTo(height(), 6);
  });

  it("keeps the size of the target with parallel rays, which zoom as well", () => {
    const parallel = setOrthographic(someScene(), true);
    expect(parallel.camera?.orthographicHeight).toBeCloseTo(height(), 9);
    const pose = cameraOf(parallel);
    if (!pose) throw new Error("no camera");
    const nearer = withCamera(parallel, { ...pose, eye: { x: 0, y: -250, z: 30 } });
    expect(nearer.camera?.orthographicHeight).toBeCloseTo(height() / 2, 9);
    expect(isOrthographic(setOrthographic(nearer, false))).toBe(false);
  });

  it("focuses on the target by default", () => {
    const pose = cameraOf(someScene());
    const distance = pose ? length(subtract(pose.eye, pose.target)) : 0;
    expect(focusOf(someScene())).toEqual({ distance, middle: true });
    expect(focusOf(setFocus(someScene(), 300))).toEqual({ distance: 300, middle: false });
    expect(focusOf(setFocus(setFocus(someScene(), 300), null)).middle).toBe(true);
  });

  it("stays when the eye moves, and can be reset without moving the eye", () => {
    const scene = setFocus(someScene(), 300);
    const pose = cameraOf(scene);
    if (!pose) throw new Error("no camera");
    const moved = withCamera(scene, { ...pose, eye: { x: 100, y: -400, z: 0 } });
    expect(moved.camera?.focalDistance).toBe(300);
    const back = resetPart(moved, someScene(), "lens");
    expect([back.camera?.focalDistance, back.camera?.eye?.x]).toEqual([0, 100]);
  });
});
