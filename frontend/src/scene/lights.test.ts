import { describe, expect, it } from "vitest";
import { dot, length, vec3 } from "../input/vec3";
import { cameraOf } from "../protocol/messages";
import type { Light, Scene } from "../protocol/gen/api/proto/scene_pb";
import { strengthOf } from "./colour";
import { directionOf, directionOnBall, fromWorld, ofPatient, seenFromFront, toWorld, unitOf } from "./direction";
import {
  addLight,
  aspectOf,
  colourLight,
  dimLight,
  intensityOf,
  lockLight,
  placeLight,
  placeOf,
  radianceOf,
  shapeLight,
  sizeLight,
  sizeOf,
  targetOf,
  turnLight,
  turnLightTo,
} from "./lights";
import { facesMiddle, someScene } from "./testing";

const light = (scene: Scene, index: number): Light => {
  const found = scene.lights[index];
  if (!found) throw new Error("no such light");
  return found;
};
const directions = [
  { right: 0, up: 0 },
  { right: -90, up: 30 },
  { right: 135, up: -60 },
  { right: 180, up: 0 },
  { right: 20, up: 89 },
];

describe("the position of a light", () => {
  it("is where it was put, for every shape, and a square faces the middle", () => {
    for (const index of [0, 1, 2, 3])
      for (const direction of directions) {
        const scene = placeLight(someScene(), index, { ...direction, distance: 700 });
        const place = placeOf(light(scene, index));
        expect(place?.up).toBeCloseTo(direction.up, 6);
        expect(Math.abs(Math.sin(((place?.right ?? 0) - direction.right) * (Math.PI / 180)))).toBeLessThan(1e-6);
        expect(place?.distance).toBeCloseTo(700, 6);
        if (index === 0) expect(facesMiddle(light(scene, index))).toBe(true);
      }
  });

  it("to the right means the picture's right if it is locked, and the patient's left if it is not", () => {
    const locked = light(placeLight(someScene(), 0, { right: 90, up: 0, distance: 100 }), 0);
    expect(locked.shape.case === "rectangle" && (locked.shape.value.corner?.x ?? 0)).toBeGreaterThan(90);
    const free = light(placeLight(someScene(), 1, { right: 90, up: 0, distance: 100 }), 1);
    expect(free.shape.case === "disk" && free.shape.value.centre?.x).toBeCloseTo(100, 9);
    expect(free.shape.case === "disk" && free.shape.value.normal?.x).toBeCloseTo(-1, 9);
  });

  it("can be changed from straight above", () => {
    const scene = placeLight(someScene(), 0, { up: 90, right: 30 });
    expect(placeOf(light(scene, 0))?.up).toBeCloseTo(90, 3);
    expect(facesMiddle(light(scene, 0))).toBe(true);
  });

  it("stays the same after locking and unlocking", () => {
    const pose = cameraOf(someScene());
    if (!pose) throw new Error("no camera");
    for (const index of [1, 2, 3]) {
      const before = light(someScene(), index);
      const there = lockLight(someScene(), index, true, pose);
      const back = light(lockLight(there, index, false, pose), index);
      expect(light(there, index).cameraLocked).toBe(true);
      expect(placeOf(back)?.distance).toBeCloseTo(placeOf(before)?.distance ?? 0, 6);
      expect(placeOf(back)?.right).toBeCloseTo(placeOf(before)?.right ?? 0, 6);
    }
  });
});

describe("the strength of a light", () => {
  it("is the same at every size", () => {
    for (const index of [0, 1, 3]) {
      const scene = someScene();
      const power = (one: Light) => strengthOf(radianceOf(one)) * (sizeOf(one) ?? 0) ** 2;
      const larger = light(sizeLight(scene, index, 3 * (sizeOf(light(scene, index)) ?? 0)), index);
      expect(power(larger)).toBeCloseTo(power(light(scene, index)), 6);
      expect(placeOf(larger)?.distance).toBeCloseTo(placeOf(light(scene, index))?.distance ?? 0, 6);
    }
  });

  it("stays the same when a point becomes a ball", () => {
    const ball = light(sizeLight(someScene(), 2, 20), 2);
    expect(strengthOf(radianceOf(ball)) * Math.PI * 100).toBeCloseTo(5000, 6);
  });

  it("is 1 if the scene does not contain it, and never 0, which would mean 1", () => {
    expect(intensityOf(light(someScene(), 0))).toBe(1);
    expect(light(dimLight(someScene(), 0, 0), 0).intensity).toBeGreaterThan(0);
  });

  it("is the same for a new light of every shape, which is above on the left", () => {
    for (const shape of ["rectangle", "disk", "sphere", "box"] as const) {
      const scene = addLight(someScene(), shape, "new", 150);
      const added = light(scene, scene.lights.length - 1);
      const place = placeOf(added);
      expect(place && place.right < 0 && place.up > 0).toBe(true);
      // A box shows three of its faces, each tilted.
      const tilted = (0.8 + 0.6 + 0.8) / Math.hypot(0.8, 0.6, 0.8);
      const part = { rectangle: 1, disk: Math.PI / 4, sphere: Math.PI / 4, box: tilted }[shape];
      const area = part * (sizeOf(added) ?? 0) ** 2;
      expect((strengthOf(radianceOf(added)) * area) / (place?.distance ?? 1) ** 2).toBeCloseTo(8, 6);
    }
  });

  it("stays the same in another colour", () => {
    const blue = light(colourLight(someScene(), 0, { $typeName: "diaphane.v1.Rgb", r: 0.1, g: 0.1, b: 0.5 }), 0);
    expect(strengthOf(radianceOf(blue))).toBeCloseTo(40, 9);
  });
});

describe("the name of a new light", () => {
  it("is numbered if another light has it", () => {
    let scene = someScene();
    const names = scene.lights.length;
    for (let i = 0; i < 3; ++i) scene = addLight(scene, "environment", "Sky", 100);
    expect(scene.lights.slice(names).map((one) => one.name)).toEqual(["Sky", "Sky 2", "Sky 3"]);
  });
});

describe("the target of a light", () => {
  it("is the middle until the light is turned, and stays where it is when the light moves", () => {
    for (const index of [0, 1]) {
      const turned = turnLight(placeLight(someScene(), index, { right: 30, up: 20 }), index, { right: 40, up: -25 });
      expect(targetOf(light(placeLight(someScene(), index, {}), index))).toEqual({ right: 0, up: 0 });
      expect(targetOf(light(turned, index))?.right).toBeCloseTo(40, 4);
      let moved = turned;
      for (const direction of directions) moved = placeLight(moved, index, { ...direction, distance: 400 });
      expect(targetOf(light(moved, index))?.right).toBeCloseTo(40, 4);
      expect(targetOf(light(moved, index))?.up).toBeCloseTo(-25, 4);
      expect(placeOf(light(turned, index))?.right).toBeCloseTo(30, 6);
    }
  });

  it("is to the right and up as the light sees it", () => {
    const scene = turnLight(placeLight(someScene(), 1, { right: 0, up: 0, distance: 500 }), 1, { right: 500, up: 0 });
    const { shape } = light(scene, 1);
    // From in front of the patient, the right is the patient's left (+x) and the way to the patient is +y.
    expect(shape.case === "disk" && shape.value.normal?.x).toBeCloseTo(Math.SQRT1_2, 6);
    expect(shape.case === "disk" && shape.value.normal?.y).toBeCloseTo(Math.SQRT1_2, 6);
  });

  it("can be a point of the picture, if it is in front of the light", () => {
    const pose = cameraOf(someScene());
    if (!pose) throw new Error("no camera");
    const front = placeLight(someScene(), 1, { right: 0, up: 0, distance: 500 });
    const turned = turnLightTo(front, 1, pose, vec3(30, 20, -10));
    if (!turned) throw new Error("not turned");
    const { shape } = light(turned, 1);
    if (shape.case !== "disk") throw new Error("no disk");
    const normal = vec3(shape.value.normal?.x ?? 0, shape.value.normal?.y ?? 0, shape.value.normal?.z ?? 0);
    const way = vec3(30, 520, -10);
    expect(dot(normal, way) / length(way)).toBeCloseTo(1, 9);
    expect(turnLightTo(front, 1, pose, vec3(0, -900, 0))).toBeNull();
  });

  it("does not exist for lights that shine in all directions", () => {
    for (const shape of ["sphere", "box", "environment"] as const) {
      const scene = addLight(someScene(), shape, "new", 100);
      expect(targetOf(light(scene, scene.lights.length - 1))).toBeNull();
      expect(turnLight(scene, scene.lights.length - 1, { right: 10 })).toBe(scene);
    }
  });
});

describe("the aspect of a light", () => {
  it("changes a square and keeps its area, its place and its brightness", () => {
    const wide = light(shapeLight(someScene(), 0, { width: 4 }), 0);
    const before = light(someScene(), 0);
    expect(aspectOf(wide)).toEqual({ width: expect.closeTo(4, 9) as number, depth: null });
    expect(sizeOf(wide)).toBeCloseTo(2 * (sizeOf(before) ?? 0), 6);
    expect(placeOf(wide)?.distance).toBeCloseTo(placeOf(before)?.distance ?? 0, 6);
    expect(strengthOf(radianceOf(wide))).toBe(strengthOf(radianceOf(before)));
  });

  it("changes a box, which is as bright as before", () => {
    const scene = addLight(someScene(), "box", "new", 100);
    const index = scene.lights.length - 1;
    const flat = light(shapeLight(shapeLight(scene, index, { width: 2 }), index, { depth: 0.1 }), index);
    expect(aspectOf(flat)?.width).toBeCloseTo(2, 9);
    expect(aspectOf(flat)?.depth).toBeCloseTo(0.1, 9);
    const edges = [Math.SQRT2, Math.SQRT1_2, 0.1 * Math.SQRT1_2] as const;
    const surface = 2 * (edges[0] * edges[1] + edges[1] * edges[2] + edges[2] * edges[0]);
    expect(strengthOf(radianceOf(flat)) * surface).toBeCloseTo(6 * strengthOf(radianceOf(light(scene, index))), 3);
    expect(placeOf(flat)?.distance).toBeCloseTo(placeOf(light(scene, index))?.distance ?? 0, 6);
  });

  it("does not exist for round lights", () => {
    expect(aspectOf(light(someScene(), 1))).toBeNull();
    expect(shapeLight(someScene(), 1, { width: 3 })).toEqual(someScene());
  });
});

describe("directions", () => {
  it("convert from the patient's frame to that of a viewer in front, and back", () => {
    const v = vec3(1, 2, 3);
    expect(ofPatient(seenFromFront(v))).toEqual(v);
    expect(seenFromFront(vec3(1, 0, 0))).toEqual(vec3(1, 0, -0)); // the patient's left is on the right of the picture
    expect(directionOf(seenFromFront(vec3(0, -1, 0)))).toEqual({ right: 0, up: 0 });
  });

  it("convert to the camera's frame and back", () => {
    const pose = cameraOf(someScene());
    if (!pose) throw new Error("no camera");
    const v = vec3(10, -20, 30);
    const back = toWorld(pose, fromWorld(pose, v));
    expect(length(vec3(back.x - v.x, back.y - v.y, back.z - v.z))).toBeLessThan(1e-9);
  });

  it("on the ball are in front in its middle, behind beyond its rim, and valid everywhere", () => {
    expect(directionOnBall(0, 0, false).direction.up).toBeCloseTo(0, 9);
    expect(directionOnBall(0.5, 0, false).direction.right).toBeCloseTo(30, 6);
    expect(directionOnBall(1.5, 0, false).direction.right).toBeCloseTo(150, 6);
    expect(directionOnBall(0, -0.5, false).direction.up).toBeCloseTo(30, 6);
    for (let x = -3; x <= 3; x += 0.25)
      for (let y = -3; y <= 3; y += 0.25) {
        const { direction } = directionOnBall(x, y, false);
        expect(dot(unitOf(direction), unitOf(direction))).toBeCloseTo(1, 9);
      }
  });
});
