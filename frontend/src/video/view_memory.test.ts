import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { ChannelSchema, SceneSchema } from "../protocol/gen/api/proto/scene_pb";
import { cameraOf, type Scene } from "../protocol/messages";
import { changed, nothingYet, type History } from "../scene/history";
import { setDensity } from "../scene/transfer";
import { someScene } from "../scene/testing";
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
    rememberView(store, "a", { session_id: "s", scene, begun: scene, input_seq: 12, steps: nothingYet });
    const back = rememberedView(store, "a");
    expect(back).toMatchObject({ session_id: "s", input_seq: 12 });
    expect(back.scene && cameraOf(back.scene)).toEqual(cameraOf(scene));
    expect(back.begun).toEqual(back.scene);
    expect(rememberedView(store, "b")).toEqual({
      session_id: null,
      scene: null,
      begun: null,
      input_seq: 0,
      steps: nothingYet,
    });
  });
  it("is silently lost if the browser stores nothing", () => {
    const full = {
      getItem: () => null,
      setItem: () => {
        throw new DOMException("no room", "QuotaExceededError");
      },
    };
    expect(() =>
      rememberView(full, "a", { session_id: "s", scene: null, begun: null, input_seq: 1, steps: nothingYet }),
    ).not.toThrow();
  });
  it("is ignored if it is damaged or of another version", () => {
    for (const text of ["{", "[]", '{"scene":"{\\"wings\\":2}"}', '{"session_id":5,"input_seq":"x"}']) {
      kept.set("diaphane.view.a", text);
      expect(rememberedView(store, "a")).toEqual({
        session_id: null,
        scene: null,
        begun: null,
        input_seq: 0,
        steps: nothingYet,
      });
    }
  });
  it("includes the steps to undo and to redo", () => {
    const densities = (scenes: readonly Scene[]) => scenes.map((one) => one.transferFunction?.extinctionPerMm);
    const steps = { past: [1, 2].map(dense), future: [dense(4)], open: null };
    rememberView(store, "a", { session_id: "s", scene: dense(3), begun: null, input_seq: 1, steps });
    const back = rememberedView(store, "a").steps;
    expect([densities(back.past), densities(back.future)]).toEqual([[1, 2], [4]]);
    rememberView(store, "b", { session_id: "s", scene: dense(3), begun: null, input_seq: 1, steps });
    expect(rememberedView(store, "b").steps.past).toHaveLength(2);
  });
  it("includes as many of the newest steps as fit into the store", () => {
    const change = { what: "density", held: false, nowMs: 0 };
    let steps: History<Scene> = nothingYet;
    const large = create(ChannelSchema, { name: "x".repeat(300_000) });
    for (const value of [1, 2, 3, 4, 5]) {
      const scene = dense(value);
      scene.transferFunction?.channels.push(large);
      steps = { ...changed(steps, scene, change), open: null };
    }
    rememberView(store, "a", { session_id: "s", scene: dense(3), begun: null, input_seq: 1, steps });
    const back = rememberedView(store, "a").steps.past;
    expect(back.map((one) => one.transferFunction?.extinctionPerMm)).toEqual([3, 4, 5]);
  });
});

const dense = (perMm: number): Scene => setDensity(someScene(), perMm);
