import { describe, expect, it } from "vitest";
import { orbitFrame, orbitOf, inPicture, type CameraPose } from "../input/camera";
import { length, subtract, vec3, type Vec3 } from "../input/vec3";
import {
  framingOf,
  identity,
  inSquare,
  inverse,
  movedPoint,
  movedPose,
  relativePose,
  type Motion,
} from "./mapped_camera";

const pose: CameraPose = {
  eye: vec3(300, -200, 120),
  target: vec3(10, 20, -30),
  up: vec3(0, 0, 1),
  verticalFovDegrees: 30,
};
/** A quarter turn about the axis from foot to head, and a shift. */
const quarter: Motion = [0, -1, 0, 5, 1, 0, 0, -7, 0, 0, 1, 11, 0, 0, 0, 1];

const near = (a: Vec3, b: Vec3) => expect(length(subtract(a, b))).toBeLessThan(1e-9);

describe("relativePose", () => {
  const from = { centre: vec3(10, 20, -30), size: 100 };
  const to = { centre: vec3(-50, 0, 200), size: 50 };

  it("looks at the other subject from the same side and as large in proportion", () => {
    const other = relativePose(pose, from, to);
    near(other.target, to.centre);
    near(subtract(other.eye, other.target), vec3(145, -110, 75));
    expect(other.up).toBe(pose.up);
  });

  it("returns to the first camera", () => {
    const back = relativePose(relativePose(pose, from, to), to, from);
    near(back.eye, pose.eye);
    near(back.target, pose.target);
  });

  it("keeps sizes that it cannot compare", () => {
    near(subtract(relativePose(pose, { ...from, size: 0 }, to).eye, to.centre), subtract(pose.eye, from.centre));
  });
});

describe("movedPose", () => {
  it("sees the same place of the other scan at the same place of the picture", () => {
    const place = vec3(40, 35, -10);
    const seen = (camera: CameraPose, at: Vec3) => inPicture(orbitFrame(orbitOf(camera)), subtract(at, camera.eye));
    near(seen(movedPose(quarter, pose), movedPoint(quarter, place)), seen(pose, place));
  });

  it("turns the up direction too, but does not shift it", () => {
    near(movedPose(quarter, { ...pose, up: vec3(1, 0, 0) }).up, vec3(0, 1, 0));
  });

  it("is undone by the inverse", () => {
    near(movedPoint(inverse(quarter), movedPoint(quarter, pose.eye)), pose.eye);
    near(movedPoint(quarter, movedPoint(inverse(quarter), pose.eye)), pose.eye);
    near(movedPoint(inverse(identity), pose.eye), pose.eye);
  });
});

describe("inSquare", () => {
  it("shows as much in a picture of another shape", () => {
    const [wide, tall] = [
      { width: 400, height: 200 },
      { width: 200, height: 400 },
    ];
    const distance = (one: CameraPose) => length(subtract(one.eye, one.target));
    const same = (one: CameraPose) => one;
    expect(distance(inSquare(pose, { from: wide, to: tall }, same))).toBeCloseTo(2 * distance(pose));
    expect(distance(inSquare(pose, { from: tall, to: wide }, same))).toBeCloseTo(distance(pose) / 2);
  });
});

describe("framingOf", () => {
  it("takes half of the picture's height at the subject", () => {
    const framing = framingOf({ ...pose, eye: vec3(10, -480, -30), verticalFovDegrees: 90 });
    expect(framing.size).toBeCloseTo(500);
    expect(framing.centre).toEqual(pose.target);
  });
});
