import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { SceneSchema } from "../protocol/gen/api/proto/scene_pb";
import { rgb } from "./colour";
import { lookColour } from "./look_colour";

const material = (red: number, opacity: number, disabled = false) => ({
  name: "",
  diffuse: rgb(red, 0, 0),
  disabled,
  opacity: [{ value: 0, opacity }],
});
const scene = (...channels: ReturnType<typeof material>[]) => create(SceneSchema, { transferFunction: { channels } });

describe("the colour of a look", () => {
  it("is that of the first material that is clearly visible", () => {
    expect(lookColour(scene(material(1, 0.1), material(0, 0.8), material(1, 0.9)))).toBe("#000000");
    expect(lookColour(scene(material(0, 1, true), material(1, 0.2)))).toBe("#ff0000");
  });
  it("is nothing where nothing is visible", () => {
    expect(lookColour(scene(material(1, 0)))).toBeNull();
    expect(lookColour(undefined)).toBeNull();
  });
});
