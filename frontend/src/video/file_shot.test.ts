import { create } from "@bufbuild/protobuf";
import { beforeEach, describe, expect, it } from "vitest";
import {
  Video_Path as VideoPath,
  FilePartSchema,
  FileProgressSchema,
  ProblemSchema,
} from "../protocol/gen/api/proto/stream_pb";
import type { FileOrder } from "../protocol/file_messages";
import { someScene } from "../scene/testing";
import { FileShot, type FileState } from "./file_shot";
import { settled, WorkerByHand } from "./testing";

const turntable: FileOrder = {
  kind: "turntable",
  keys: [someScene()],
  size: { width: 640, height: 480 },
  frames: 200,
  framesPerSecond: 25,
  phaseCycles: 0,
  error: 0.05,
};

class World extends WorkerByHand<FileState> {
  shot: FileShot;

  constructor(order: FileOrder = turntable) {
    super();
    this.shot = new FileShot(order, this.parts);
  }
  part(seq: bigint, text: string, last = false): void {
    this.say({ case: "filePart", value: create(FilePartSchema, { seq, data: new TextEncoder().encode(text), last }) });
  }
  problem(code: string, field: string, fatal = false): void {
    this.say({ case: "problem", value: create(ProblemSchema, { code, field, fatal, message: "Too many lights." }) });
  }
}

let world: World;
beforeEach(async () => {
  world = new World();
  await world.live();
});

describe("an exported file", () => {
  it("is ordered with its views by a session that renders nothing else", () => {
    expect(world.cases).toEqual(["hello", "visibility", "keyView", "file"]);
    const hello = world.sent[0]?.body;
    expect(hello?.case === "hello" && hello.value.viewport).toMatchObject({ width: 16, height: 16 });
    const seen = world.sent[1]?.body;
    expect(seen?.case === "visibility" && seen.value.visible).toBe(false);
    const file = world.sent[3]?.body;
    expect(file?.case === "file" && file.value.kind.case === "video" && file.value.kind.value).toMatchObject({
      path: VideoPath.TURNTABLE,
      frames: 200,
      framesPerSecond: 25,
      width: 640,
      height: 480,
      error: 0.05,
    });
  });
  it("reports its progress and is assembled from its parts", async () => {
    world.say({ case: "fileProgress", value: create(FileProgressSchema, { done: 0.25 }) });
    expect(world.state).toEqual({ kind: "rendering", done: 0.25, waits: null });
    world.part(1n, "one ");
    world.part(2n, "two", true);
    expect(world.state?.kind).toBe("done");
    const file = world.state?.kind === "done" ? world.state.file : new Blob();
    expect(file.type).toBe("video/mp4");
    expect(await file.text()).toBe("one two");
    expect(world.open).toBe(false);
  });
  it("acknowledges each part, so that more come", () => {
    world.part(1n, "one ");
    world.part(2n, "two");
    expect(world.sent.flatMap(({ body }) => (body.case === "fileTaken" ? [body.value.seq] : []))).toEqual([1n, 2n]);
  });
  it("is discarded if a part is missing", () => {
    world.part(1n, "one ");
    world.part(3n, "three", true);
    expect(world.state).toMatchObject({ kind: "failed", trouble: "refused" });
  });
  it("starts again on another worker", async () => {
    world.part(1n, "old");
    world.config();
    expect(world.cases.filter((one) => one === "file")).toHaveLength(2);
    world.part(1n, "new", true);
    expect(world.state?.kind === "done" && (await world.state.file.text())).toBe("new");
  });
  it("ends when it is cancelled, and reports nothing afterwards", () => {
    world.shot.stop();
    expect(world.state).toMatchObject({ kind: "failed", trouble: "stopped" });
    expect(world.open).toBe(false);
    const told = world.states.length;
    world.say({ case: "fileProgress", value: create(FileProgressSchema, { done: 1 }) });
    world.part(1n, "one", true);
    expect(world.states).toHaveLength(told);
  });
  it("ends with a message if it is refused", () => {
    world.problem("too_many", "file");
    expect(world.state).toMatchObject({ kind: "failed", trouble: "busy" });
    const refused = new World();
    refused.shot.start();
    return settled().then(async () => {
      refused.socket?.opened();
      refused.config();
      await settled();
      refused.problem("invalid", "file");
      expect(refused.state).toEqual({ kind: "failed", trouble: "refused_scene", message: "Too many lights." });
    });
  });
});

it("orders a large picture as a PNG of one view", async () => {
  const large = new World({ kind: "picture", keys: [someScene()], size: { width: 8192, height: 6144 }, error: 0.02 });
  await large.live();
  const file = large.sent.at(-1)?.body;
  expect(file?.case === "file" && file.value.kind.case === "picture" && file.value.kind.value).toMatchObject({
    width: 8192,
    height: 6144,
    error: 0.02,
  });
  large.part(1n, "png", true);
  expect(large.state?.kind === "done" && large.state.file.type).toBe("image/png");
});

it("orders a tour with all its views in order", async () => {
  const tour = new World({ ...turntable, kind: "tour", keys: [someScene(), someScene(), someScene()] });
  await tour.live();
  expect(tour.sent.flatMap(({ body }) => (body.case === "keyView" ? [body.value.index] : []))).toEqual([0, 1, 2]);
});

it("reports that no rendering time is left, and ends", async () => {
  const spent = new World();
  spent.ticketSource = () => Promise.resolve({ ok: false, trouble: "time_spent", final: true });
  spent.shot.start();
  await settled();
  expect(spent.state).toEqual({ kind: "failed", trouble: "time_spent", message: "" });
});
