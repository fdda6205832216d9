import { describe, expect, it } from "vitest";
import { inPicture, orbitFrame, orbitOf, panned, poseOf, refitted, rolled, rotated, zoomed } from "./camera";
import type { CameraPose } from "./camera";
import { cross, dot, length, scale, subtract, vec3, type Vec3 } from "./vec3";

// In front of the patient: the eye is at -y (the back is +y), the head is up.
const front: CameraPose = { eye: vec3(0, -500, 0), target: vec3(0, 0, 0), up: vec3(0, 0, 1), verticalFovDegrees: 30 };

function near(a: Vec3, b: Vec3, tolerance = 1e-6): void {
  expect(length(subtract(a, b))).toBeLessThan(tolerance);
}

/** The picture of a point: x to the right, y up, in parts of half the height. */
function projected(pose: CameraPose, point: Vec3): { x: number; y: number } {
  const frame = orbitFrame(orbitOf(pose));
  const p = inPicture(frame, subtract(point, pose.eye));
  const half = Math.tan((pose.verticalFovDegrees * Math.PI) / 360);
  return { x: p.x / (-p.z * half), y: p.y / (-p.z * half) };
}

describe("the turntable camera", () => {
  const poses: CameraPose[] = [
    front,
    { eye: vec3(300, -200, 120), target: vec3(10, 20, -30), up: vec3(0, 0, 1), verticalFovDegrees: 45 },
    { eye: vec3(-300, 210, -320), target: vec3(10, 20, -30), up: vec3(0, 0, 1), verticalFovDegrees: 45 },
  ];

  it("converts to an orbit and back", () => {
    for (const pose of poses) {
      const back = poseOf(orbitOf(pose));
      near(back.eye, pose.eye);
      near(back.target, pose.target);
      const again = poseOf(orbitOf(back));
      near(again.up, back.up);
    }
  });

  it("keeps its roll when converted", () => {
    for (const pose of poses) {
      const turned = rolled(orbitOf(pose), 0.7);
      expect(orbitOf(poseOf(turned)).roll).toBeCloseTo(turned.roll, 9);
    }
  });

  it("has a right-handed orthonormal frame with the head upwards", () => {
    for (const pose of poses) {
      const frame = orbitFrame(orbitOf(pose));
      near(cross(frame.right, frame.up), frame.back);
      expect(length(frame.right)).toBeCloseTo(1, 12);
      expect(frame.up.z).toBeGreaterThan(0);
    }
  });

  it("shows the patient's left on the right from the front", () => {
    const frame = orbitFrame(orbitOf(front));
    near(inPicture(frame, vec3(1, 0, 0)), vec3(1, 0, 0));
    near(inPicture(frame, vec3(0, 0, 1)), vec3(0, 1, 0));
    near(inPicture(frame, vec3(0, -1, 0)), vec3(0, 0, 1));
  });

  it("moves the near side with the pointer, at any roll", () => {
    for (const roll of [0, 0.5, Math.PI / 2, Math.PI, -2]) {
      const orbit = rolled(orbitOf(front), roll);
      const nearest = scale(orbitFrame(orbit).back, 80);
      for (const [right, down] of [
        [0.01, 0],
        [0, 0.01],
      ] as const) {
        const after = poseOf(rotated(orbit, right, down));
        const p = inPicture(orbitFrame(orbitOf(after)), subtract(nearest, after.eye));
        expect(p.x).toBeCloseTo(80 * Math.sin(right), 2);
        expect(-p.y).toBeCloseTo(80 * Math.sin(down), 2);
      }
    }
  });

  it("never passes the pole, and keeps its distance when it rotates", () => {
    let orbit = orbitOf(front);
    for (let i = 0; i < 500; i++) {
      orbit = rotated(orbit, 0.11, i < 250 ? 0.05 : -0.07);
      const pose = poseOf(orbit);
      expect(pose.up.z).toBeGreaterThan(0);
      expect(length(subtract(pose.eye, pose.target))).toBeCloseTo(500, 6);
      expect(dot(pose.up, subtract(pose.eye, pose.target))).toBeCloseTo(0, 6);
    }
  });

  it("moves the target's picture by the panned fraction of its height", () => {
    for (const roll of [0, 1.1]) {
      const orbit = rolled(orbitOf(poses[1] ?? front), roll);
      const after = poseOf(panned(orbit, 0.1, 0.2));
      const p = projected(after, orbit.target);
      expect(p.x).toBeCloseTo(0.2, 6);
      expect(p.y).toBeCloseTo(-0.4, 6);
    }
  });

  it("is unchanged after zooming by a factor and its inverse, and stops at its limits", () => {
    const orbit = orbitOf(front);
    expect(zoomed(zoomed(orbit, 1.3), 1 / 1.3).distance).toBeCloseTo(500, 9);
    expect(zoomed(orbit, 1e9).distance).toBe(5);
    expect(zoomed(orbit, 1e-9).distance).toBe(20_000);
    expect(zoomed(orbit, Number.NaN)).toEqual(orbit);
    expect(zoomed(orbit, 2).distance).toBeCloseTo(250, 9);
  });

  it("turns the picture clockwise with a positive roll", () => {
    const after = poseOf(rolled(orbitOf(front), 0.1));
    const head = projected(after, vec3(0, 0, 50));
    expect(head.x).toBeGreaterThan(0);
    expect(head.y).toBeGreaterThan(0);
  });

  it("keeps the top of the picture from straight above", () => {
    for (const up of [vec3(0, -1, 0), vec3(1, 0, 0)]) {
      for (const z of [400, -400]) {
        const pose: CameraPose = { eye: vec3(0, 0, z), target: vec3(0, 0, 0), up, verticalFovDegrees: 30 };
        near(poseOf(orbitOf(pose)).up, up, 0.02);
      }
    }
  });

  it("keeps the subject in the picture when the window becomes narrow, and goes back when it widens", () => {
    const narrow = refitted(front, 1.6, 0.5);
    expect(projected(narrow, vec3(60, 0, 0)).x).toBeCloseTo(projected(front, vec3(60, 0, 0)).x / 2, 9);
    near(refitted(narrow, 0.5, 1.6).eye, front.eye);
    expect(refitted(front, 1.6, 1.2)).toBe(front);
    expect(refitted(front, 1.6, 0)).toBe(front);
  });
});
