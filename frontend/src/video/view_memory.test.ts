import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { SceneSchema } from "../protocol/gen/api/proto/scene_pb";
import { cameraOf } from "../protocol/messages";
import { rememberView, rememberedView } from "./view_memory";

const kept = new Map<string, string>();
const store = {
  getItem: (key: string) => kept.get(key) ?? null,
  setItem: (key: string, value: string) => void kept.set(key, value),
};

describe("the remembered view", () => {
  it("is restored for its data set only", () => {
    const scene = create(SceneSchema, {
      camera: { eye: { x: 1, y: -500.25, z: 3 }, target: {}, up: { z: 1 }, verticalFovDegrees: 30 },
    });
    rememberView(store, "a", { session_id: "s", scene, begun: scene, input_seq: 12 });
    const back = rememberedView(store, "a");
    expect(back).toMatchObject({ session_id: "s", input_seq: 12 });
    expect(back.scene && cameraOf(back.scene)).toEqual(cameraOf(scene));
    expect(back.begun).toEqual(back.scene);
    expect(rememberedView(store, "b")).toEqual({ session_id: null, scene: null, begun: null, input_seq: 0 });
  });
  it("is silently lost if the browser stores nothing", () => {
    const full = {
      getItem: () => null,
      setItem: () => {
        throw new DOMException("no room", "QuotaExceededError");
      },
    };
    expect(() => rememberView(full, "a", { session_id: "s", scene: null, begun: null, input_seq: 1 })).not.toThrow();
  });
  it("is ignored if it is damaged or of another version", () => {
    for (const text of ["{", "[]", '{"scene":"{\\"wings\\":2}"}', '{"session_id":5,"input_seq":"x"}']) {
      kept.set("diaphane.view.a", text);
      expect(rememberedView(store, "a")).toEqual({ session_id: null, scene: null, begun: null, input_seq: 0 });
    }
  });
});
