import { describe, expect, it } from "vitest";
import { cubeFaces } from "./cube";
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
});
