import { describe, expect, it } from "vitest";
import { orbitOf } from "./camera";
import { cubeFaces, poseFromSide } from "./cube";
import { vec3 } from "./vec3";

const from = (x: number, y: number, z: number) =>
  cubeFaces({ eye: vec3(x, y, z), target: vec3(0, 0, 0), up: vec3(0, 0, 1), verticalFovDegrees: 30 });

describe("the orientation cube", () => {
  it("shows the viewed side", () => {
    expect(from(0, -500, 0).at(-1)?.letter).toBe("A");
    expect(from(0, 500, 0).at(-1)?.letter).toBe("P");
    expect(from(500, 0, 0).at(-1)?.letter).toBe("L");
    expect(from(-500, 0, 1).at(-1)?.letter).toBe("R");
    expect(from(0, -1, 500).at(-1)?.letter).toBe("S");
  });
  it("has the patient's left on the right when viewed from the front, and the head above", () => {
    const faces = from(200, -500, 200);
    const middle = (letter: string) => faces.find((face) => face.letter === letter)?.middle ?? { x: 0, y: 0 };
    expect(middle("L").x).toBeGreaterThan(middle("A").x);
    expect(middle("S").y).toBeLessThan(middle("A").y); // y goes down
    expect(faces.map((face) => face.letter).sort()).toEqual(["A", "L", "S"]);
  });
  it("turns to the side that is pressed, upright and at the same distance", () => {
    const pose = { eye: vec3(210, -480, 215), target: vec3(10, 20, 15), up: vec3(0.3, 0, 0.9), verticalFovDegrees: 30 };
    for (const letter of ["L", "R", "A", "P", "S", "I"]) {
      const turned = poseFromSide(pose, letter);
      expect(cubeFaces(turned).map((face) => face.letter)).toEqual([letter]);
      expect(orbitOf(turned).distance).toBeCloseTo(orbitOf(pose).distance, 6);
      expect(orbitOf(turned).roll).toBeCloseTo(0, 6);
      expect(turned.target).toEqual(pose.target);
    }
    // From above, the patient's left stays on the right of the picture, as from the front.
    for (const letter of ["S", "I"])
      expect(orbitOf(poseFromSide(pose, letter)).azimuth).toBeCloseTo(orbitOf(poseFromSide(pose, "A")).azimuth, 6);
  });
});
