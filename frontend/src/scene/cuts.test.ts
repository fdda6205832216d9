import { describe, expect, it } from "vitest";
import { length, subtract } from "../input/vec3";
import { camera_of } from "../protocol/messages";
import { add_plane, box_of, cuts_light, face_limits, move_face, move_plane, planes_of, set_alone, set_cuts_light, set_slice } from "./cuts";
import { focus_of, height_at_target, is_orthographic, set_focus, set_fov, set_orthographic } from "./lens";
import { reset_part } from "./parts";
import { some_bounds, some_scene } from "./testing";
import { with_camera } from "../protocol/messages";

const grey = { centre: 300, width: 1500 };

describe("the box", () => {
  it("goes as far as it is told, and is none again when it is whole", () => {
    const cut = move_face(some_scene(), some_bounds, "x", "high", 10);
    expect(box_of(cut, some_bounds).high).toEqual({ ...some_bounds.high, x: 10 });
    const whole = move_face(cut, some_bounds, "x", "high", 500);
    expect([whole.clip?.boxLow, whole.clip?.boxHigh]).toEqual([undefined, undefined]);
  });

  it("its faces never pass each other", () => {
    const cut = move_face(some_scene(), some_bounds, "z", "high", -50);
    expect(face_limits(cut, some_bounds, "z", "low")).toEqual({ low: -80, high: -51 });
    expect(box_of(move_face(cut, some_bounds, "z", "low", 70), some_bounds).low.z).toBe(-51);
  });
});

describe("light", () => {
  it("falls on what a new cut lays open, until that is said otherwise", () => {
    const cut = move_face(some_scene(), some_bounds, "y", "low", 0);
    expect(cut.clip?.cutsLight).toBe(true);
    expect(add_plane(some_scene()).clip?.cutsLight).toBe(true);
    expect(cuts_light(move_face(set_cuts_light(cut, false), some_bounds, "y", "low", 10))).toBe(false);
  });
});

describe("a plane", () => {
  it("begins in front and cuts the patient's front away", () => {
    const plane = add_plane(some_scene()).clip?.planes[0];
    expect(plane?.normal?.y).toBeCloseTo(-1, 12);
  });

  it("is told back as it was set", () => {
    const scene = move_plane(add_plane(some_scene()), some_bounds, 0, { right: 40, up: -25, offset: 33 });
    const [plane] = planes_of(scene);
    expect([plane?.right, plane?.up, plane?.offset].map((n) => Number(n?.toFixed(6)))).toEqual([40, -25, 33]);
  });

  it("there are six at most", () => {
    let scene = some_scene();
    for (let i = 0; i < 9; i++) scene = add_plane(scene);
    expect(planes_of(scene).length).toBe(6);
  });
});

describe("slices", () => {
  it("have the scan's own grey from the first on", () => {
    const scene = set_slice(some_scene(), some_bounds, grey, "axial", { shown: true });
    expect([scene.slices?.windowCentre, scene.slices?.windowWidth]).toEqual([300, 1500]);
  });

  it("are alone only while there is one: the last one that goes brings the matter back", () => {
    const alone = set_alone(set_slice(some_scene(), some_bounds, grey, "axial", { shown: true }), grey, true);
    expect(alone.slices?.alone).toBe(true);
    expect(set_slice(alone, some_bounds, grey, "axial", { shown: false }).slices?.alone).toBe(false);
    expect(set_alone(some_scene(), grey, true).slices?.alone).toBe(false);
  });
});

describe("the lens", () => {
  const height = (scene = some_scene()) => {
    const pose = camera_of(scene);
    return pose ? height_at_target(pose) : 0;
  };
  it("at any field of view the middle stays as large", () => {
    for (const fov of [5, 15, 60, 100]) expect(height(set_fov(some_scene(), fov))).toBeCloseTo(height(), 6);
  });

  it("parallel rays show the middle as large, and zooming zooms them", () => {
    const parallel = set_orthographic(some_scene(), true);
    expect(parallel.camera?.orthographicHeight).toBeCloseTo(height(), 9);
    const pose = camera_of(parallel);
    if (!pose) throw new Error("no camera");
    const nearer = with_camera(parallel, { ...pose, eye: { x: 0, y: -250, z: 30 } });
    expect(nearer.camera?.orthographicHeight).toBeCloseTo(height() / 2, 9);
    expect(is_orthographic(set_orthographic(nearer, false))).toBe(false);
  });

  it("is sharp at the middle until told otherwise", () => {
    const pose = camera_of(some_scene());
    const distance = pose ? length(subtract(pose.eye, pose.target)) : 0;
    expect(focus_of(some_scene())).toEqual({ distance, middle: true });
    expect(focus_of(set_focus(some_scene(), 300))).toEqual({ distance: 300, middle: false });
    expect(focus_of(set_focus(set_focus(some_scene(), 300), null)).middle).toBe(true);
  });

  it("stays when the eye moves, and comes back without moving the eye", () => {
    const scene = set_focus(some_scene(), 300);
    const pose = camera_of(scene);
    if (!pose) throw new Error("no camera");
    const moved = with_camera(scene, { ...pose, eye: { x: 100, y: -400, z: 0 } });
    expect(moved.camera?.focalDistance).toBe(300);
    const back = reset_part(moved, some_scene(), "lens");
    expect([back.camera?.focalDistance, back.camera?.eye?.x]).toEqual([0, 100]);
  });
});
