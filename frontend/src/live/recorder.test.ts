import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { CameraSchema, SceneSchema, Vec3Schema, TransferFunctionSchema } from "../protocol/gen/api/proto/scene_pb";
import { Recorder } from "./recorder";

const seenFrom = (x: number, extinction = 1) =>
  create(SceneSchema, {
    camera: create(CameraSchema, {
      eye: create(Vec3Schema, { x }),
      target: create(Vec3Schema, { x: 1 }),
      verticalFovDegrees: 40,
    }),
    transferFunction: create(TransferFunctionSchema, { extinctionPerMm: extinction }),
  });
const size = { width: 640, height: 480 };

describe("the recorder", () => {
  it("records a scene once and then only its camera, with times from the start", () => {
    const recorder = new Recorder();
    recorder.add(seenFrom(1), 1_000_000, size);
    recorder.add(seenFrom(2), 1_000_016.4, size);
    recorder.add(seenFrom(2, 3), 1_000_100, size);
    const events = recorder.take(size)?.events ?? [];
    expect(events.map((event) => [event.at_ms, Object.keys(event)[1]])).toEqual([
      [0, "scene"],
      [16, "camera"],
      [100, "scene"],
    ]);
    expect(events[1]?.camera).toMatchObject({ eye: { x: 2 } });
  });

  it("shortens a long pause and never goes back in time", () => {
    const recorder = new Recorder();
    for (const at of [0, 3_600_000, 3_599_000]) recorder.add(seenFrom(at), at, size);
    expect(recorder.take(size)?.events.map((event) => event.at_ms)).toEqual([0, 10_000, 10_000]);
  });

  it("splits a long recording into parts that each start with a scene", () => {
    const recorder = new Recorder();
    const parts = [];
    for (let i = 0; i < 9000; ++i) {
      const part = recorder.add(seenFrom(i), i * 16, size);
      if (part) parts.push(part);
    }
    parts.push(recorder.take(size));
    expect(parts.length).toBeGreaterThan(2);
    expect(parts.reduce((sum, part) => sum + (part?.events.length ?? 0), 0)).toBe(9000);
    for (const part of parts) {
      expect(part?.events[0]?.scene).toBeDefined();
      expect(part?.events[0]?.at_ms).toBe(0);
    }
  });

  it("returns nothing for a picture that was only viewed", () => {
    const recorder = new Recorder();
    expect(recorder.take(size)).toBeNull();
    recorder.add(seenFrom(1), 0, size);
    expect(recorder.take(size)).toBeNull();
  });
});
