import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { fullEffort } from "../scene/effort";
import { SceneSchema, type Scene } from "./gen/api/proto/scene_pb";
import {
  AnatomicalPlane,
  ClientMessageSchema,
  Codec,
  AudienceSchema,
  ConfigSchema,
  ExactSliceSchema,
  FilePartSchema,
  FileProgressSchema,
  FrameSchema,
  LookSchema,
  ProblemSchema,
  SlicesStaleSchema,
  StateSchema,
  ServerMessageSchema,
  StillFormat,
  StillSchema,
  type ClientMessage,
  type ServerMessage,
} from "./gen/api/proto/stream_pb";
import { StreamClient, type SocketEvents } from "./stream_client";

const scene = (x: number): Scene => create(SceneSchema, { camera: { eye: { x, y: 0, z: 0 }, target: {} } });

/** A world by hand: nothing happens until the test says so. */
class World {
  sent: ClientMessage[] = [];
  sockets: SocketEvents[] = [];
  urls: string[] = [];
  timers: (() => void)[] = [];
  frames: (() => void)[] = [];
  seen: string[] = [];
  configs: (number | undefined)[] = [];
  looks: (number | undefined)[] = [];
  tickets = 0;
  nowMs = 0;
  reachable = true;
  client: StreamClient;

  constructor() {
    this.client = new StreamClient(
      {
        ticketSource: () => Promise.resolve({ ok: true, url: `/stream?ticket=${++this.tickets}` }),
        openSocket: (url, events) => {
          this.urls.push(url);
          this.sockets.push(events);
          return { send: (data) => this.sent.push(fromBinary(ClientMessageSchema, data)), close: () => undefined };
        },
        nextFrame: (task) => this.frames.push(task),
        after: (_ms, task) => {
          this.timers.push(task);
          return () => (this.timers = this.timers.filter((one) => one !== task));
        },
        chance: () => 0.5,
        nowMs: () => this.nowMs,
        probe: () => Promise.resolve(this.reachable),
        abilities: { codecs: [Codec.JPEG], stills: [StillFormat.PNG] },
        pixelRatio: () => 2,
      },
      {
        connection: (state) => this.seen.push(state.phase),
        config: (config) => this.configs.push(config.scene?.camera?.eye?.x),
        frame: () => this.seen.push("frame"),
        still: () => this.seen.push("still"),
        slice: () => this.seen.push("slice"),
        slicesStale: () => this.seen.push("slices stale"),
        state: () => undefined,
        audience: () => this.seen.push("audience"),
        look: (scene) => this.looks.push(scene.camera?.eye?.x),
        stats: () => undefined,
        fileProgress: (done) => this.seen.push(`file ${done}`),
        filePart: (part) => this.seen.push(`part ${part.seq}`),
        volumePhases: ({ loaded }) => this.seen.push(`${loaded} phases`),
        goodViews: (views) => this.seen.push(`${views.views.length} views`),
        errorCurve: (curve) => this.seen.push(`curve of ${curve.points.length}`),
        shared: () => this.seen.push("shared"),
        markSight: () => this.seen.push("markSight"),
        labels: () => this.seen.push("labels"),
        kernel: (report) => this.seen.push(`without ${report.leftOut.join(", ")}`),
        problem: () => this.seen.push("problem"),
      },
      { width: 640, height: 480 },
    );
  }

  say(body: ServerMessage["body"]): void {
    this.sockets.at(-1)?.message(toBinary(ServerMessageSchema, create(ServerMessageSchema, { body })));
  }
  config(x: number, inputSeq: number, follower = false): void {
    this.say({
      case: "config",
      value: create(ConfigSchema, { scene: scene(x), inputSeq: BigInt(inputSeq), follower }),
    });
  }
  screen(): void {
    for (const task of this.frames.splice(0)) task();
  }
  timeout(): void {
    for (const task of this.timers.splice(0)) task();
  }
  async live(x = 1, inputSeq = 0): Promise<void> {
    await Promise.resolve();
    this.sockets.at(-1)?.opened();
    this.config(x, inputSeq);
    this.screen();
  }
  updates(): { seq: number; x: number | undefined }[] {
    return this.sent.flatMap(({ body }) =>
      body.case === "scene" ? [{ seq: Number(body.value.inputSeq), x: body.value.scene?.camera?.eye?.x }] : [],
    );
  }
}

describe("the stream client", () => {
  let world: World;
  beforeEach(() => {
    world = new World();
    world.client.start();
  });

  it("reconnects when nothing answers a drag and the server can't be reached", async () => {
    await world.live();
    world.say({ case: "state", value: create(StateSchema, { converged: true }) });
    world.client.setScene(scene(2));
    world.reachable = false;
    world.nowMs = 3000;
    world.timeout();
    await vi.waitFor(() => expect(world.client.connection.phase).toBe("waiting"));
    expect(world.client.connection).toMatchObject({ trouble: "lost", wasLive: true });
  });

  it("greets with what it can decode and the size of its picture, before all else", async () => {
    await Promise.resolve();
    world.client.setScene(scene(5));
    world.screen();
    world.sockets[0]?.opened();
    expect(world.sent.map((m) => m.body.case)).toEqual(["hello"]);
    expect(world.sent[0]?.body.value).toMatchObject({
      protocol: 1,
      codecs: [Codec.JPEG],
      stills: [StillFormat.PNG],
      pixelRatio: 2,
      viewport: { width: 640 },
    });
  });

  it("sends a scene immediately, and of the following ones only the newest per screen refresh", async () => {
    await world.live();
    for (const x of [2, 3, 4]) world.client.setScene(scene(x));
    expect(world.updates()).toEqual([{ seq: 1, x: 2 }]);
    world.screen();
    world.client.setScene(scene(5));
    expect(world.updates()).toHaveLength(2);
    world.screen();
    world.screen();
    world.client.setScene(scene(6));
    expect(world.updates()).toEqual([
      { seq: 1, x: 2 },
      { seq: 2, x: 4 },
      { seq: 3, x: 5 },
      { seq: 4, x: 6 },
    ]);
  });

  it("reports the end of a gesture with its last scene or after it, but not for the next gesture", async () => {
    await world.live();
    const rests = () => world.sent.flatMap(({ body }) => (body.case === "scene" ? [body.value.rest] : []));
    world.client.setScene(scene(2));
    world.client.setScene(scene(3));
    world.client.rest();
    world.screen();
    expect(rests()).toEqual([false, true]);
    world.screen();
    world.client.setScene(scene(4));
    world.screen();
    world.client.rest();
    expect(rests()).toEqual([false, true, false, true]);
    expect(world.client.inputSeq).toBe(4);
  });

  it("takes over a newer scene of the session and continues its numbering", async () => {
    await world.live(7, 41);
    expect(world.updates()).toEqual([]);
    expect(world.configs).toEqual([7]);
    world.client.setScene(scene(8));
    world.screen();
    expect(world.updates()).toEqual([{ seq: 42, x: 8 }]);
  });

  it("sends its scene again after a loss and in a new session", async () => {
    await world.live(1, 0);
    world.client.setScene(scene(9));
    world.screen();
    world.sockets.at(-1)?.closed(4503);
    world.timeout();
    await world.live(1, 0);
    expect(world.urls).toEqual(["/stream?ticket=1", "/stream?ticket=2"]);
    expect(world.updates()).toEqual([
      { seq: 1, x: 9 },
      { seq: 2, x: 9 },
    ]);
    expect(world.configs).toEqual([1, 9]);
  });

  it("sends nothing to a worker that has everything", async () => {
    await world.live(1, 0);
    world.client.setScene(scene(9));
    world.screen();
    world.sockets.at(-1)?.closed(1006);
    world.timeout();
    await world.live(9, 1);
    expect(world.updates()).toHaveLength(1);
  });

  it("sends changes made while disconnected once it is back", async () => {
    await world.live(1, 0);
    world.sockets.at(-1)?.closed(1006);
    world.client.setScene(scene(3));
    world.screen();
    world.timeout();
    await world.live(1, 0);
    expect(world.updates()).toEqual([{ seq: 1, x: 3 }]);
  });

  it("sends a remembered scene only to a worker that has not seen it", async () => {
    const again = new World();
    again.client.remember(scene(6), 12);
    again.client.start();
    await again.live(6, 12);
    expect(again.updates()).toEqual([]);
    const next = new World();
    next.client.remember(scene(6), 12);
    next.client.start();
    await next.live(1, 0);
    expect(next.updates()).toEqual([{ seq: 13, x: 6 }]);
  });

  it("ignores events of an old socket", async () => {
    await world.live();
    const old = world.sockets[0];
    old?.closed(1006);
    world.timeout();
    await world.live();
    const before = world.seen.length;
    old?.message(
      toBinary(
        ServerMessageSchema,
        create(ServerMessageSchema, { body: { case: "frame", value: create(FrameSchema) } }),
      ),
    );
    old?.closed(1006);
    expect(world.seen).toHaveLength(before);
    expect(world.client.connection.phase).toBe("live");
  });

  it("ends the connection after an invalid message, but not the page", async () => {
    await world.live();
    world.sockets.at(-1)?.message(new Uint8Array([0xff, 0xff, 0xff, 0xff]));
    expect(world.client.connection).toMatchObject({ phase: "waiting", trouble: "refused" });
  });

  it("sends a change of size without a scene", async () => {
    await world.live();
    world.client.setViewport({ width: 800, height: 600 });
    world.screen();
    expect(world.updates()).toEqual([{ seq: 1, x: undefined }]);
  });

  it("changes its abilities over a new connection, and the worker keeps its scene", async () => {
    await world.live(1, 0);
    world.client.setScene(scene(2));
    world.screen();
    world.client.greetAgain({ codecs: [Codec.MPEG1], stills: [] });
    await world.live(2, 1);
    const greetings = world.sent.flatMap(({ body }) => (body.case === "hello" ? [body.value.codecs] : []));
    expect(greetings).toEqual([[Codec.JPEG], [Codec.MPEG1]]);
    expect(world.tickets).toBe(2);
    expect(world.updates()).toEqual([{ seq: 1, x: 2 }]);
  });

  it("requests a key frame only while connected", async () => {
    world.client.needKey();
    await world.live();
    world.client.needKey();
    expect(world.sent.map((m) => m.body.case)).toEqual(["hello", "needKey"]);
  });

  it("expects pictures only while connected and on the screen", async () => {
    expect(world.client.isOwedPictures).toBe(false);
    await world.live();
    expect(world.client.isOwedPictures).toBe(true);
    world.client.setVisible(false);
    expect(world.client.isOwedPictures).toBe(false);
  });

  it("sends requests only while connected", async () => {
    const ask = () => {
      world.client.wantSlices([{ plane: "coronal", index: 3 }], 7n);
      world.client.handOver("ann");
      world.client.setGuestSlices(true);
    };
    ask();
    await world.live();
    ask();
    expect(world.sent.map((m) => m.body.case)).toEqual(["hello", "slices", "handover", "guestSlices"]);
    expect(world.sent[1]?.body.value).toMatchObject({
      slices: [{ plane: AnatomicalPlane.CORONAL, index: 3 }],
      taken: 7n,
    });
    world.sockets.at(-1)?.closed(4503);
    ask();
    expect(world.sent).toHaveLength(4);
  });

  const audience = (presenter: string, freeCamera = false) =>
    world.say({
      case: "audience",
      value: create(AudienceSchema, {
        you: "me",
        presenter,
        participants: [
          { id: "me", freeCamera },
          { id: "ann", presenter: presenter === "ann" },
        ],
      }),
    });

  it("sends no scene as a follower, and takes over the presenter's", async () => {
    await world.live(1, 0);
    world.client.setScene(scene(5));
    await Promise.resolve();
    world.config(9, 3, true);
    world.client.setScene(scene(6));
    world.screen();
    expect(world.updates()).toEqual([{ seq: 1, x: 5 }]);
    expect(world.configs.at(-1)).toBe(9);
    world.say({ case: "look", value: create(LookSchema, { scene: scene(10), inputSeq: 4n }) });
    expect(world.looks).toEqual([10]);
  });

  it("ignores a late scene of the last presenter once it has changed the scene itself", async () => {
    await world.live(1, 0);
    const presents = (presenter: string) =>
      world.say({ case: "audience", value: create(AudienceSchema, { you: "me", presenter }) });
    const looks = (x: number) => world.say({ case: "look", value: create(LookSchema, { scene: scene(x) }) });
    presents("other");
    looks(2);
    presents("me");
    looks(3);
    world.client.setScene(scene(4));
    looks(5);
    expect(world.looks).toEqual([2, 3]);
    presents("other");
    looks(6);
    expect(world.looks).toEqual([2, 3, 6]);
  });

  it("sends the effort with and without a scene, but not the full effort", async () => {
    await world.live(1, 0);
    expect(world.updates()).toEqual([]);
    const effort = { smooth: false, stop_error: 0.1, stop_samples: 0, moving_scale: 0.5 };
    world.client.setEffort(effort);
    world.screen();
    const said = () => world.sent.flatMap(({ body }) => (body.case === "scene" ? [body.value] : [])).at(-1);
    expect(said()).toMatchObject({ raw: true, effort: { stopError: 0.1, movingScale: 0.5 } });
    expect(said()?.scene).toBeUndefined();
    world.client.setScene(scene(6));
    world.screen();
    expect(said()).toMatchObject({ raw: true, effort: { stopError: 0.1 } });
    world.sockets.at(-1)?.closed(4503);
    world.timeout();
    await Promise.resolve();
    await Promise.resolve();
    world.sockets.at(-1)?.opened();
    const before = world.updates().length;
    world.config(6, 2);
    world.screen();
    expect(world.updates()).toHaveLength(before + 1);
    expect(said()).toMatchObject({ raw: true, effort: { stopError: 0.1 } });
  });

  it("sends an effort that was chosen while disconnected", async () => {
    await world.live(1, 0);
    world.client.setEffort({ ...fullEffort, stop_error: 0.1 });
    world.screen();
    world.sockets.at(-1)?.closed(4503);
    world.client.setEffort(fullEffort);
    world.timeout();
    await Promise.resolve();
    await Promise.resolve();
    world.sockets.at(-1)?.opened();
    const before = world.sent.length;
    world.config(6, 2);
    world.screen();
    const said = world.sent.slice(before).flatMap(({ body }) => (body.case === "scene" ? [body.value] : []));
    expect(said.map(({ effort }) => effort?.stopError ?? 0)).toEqual([0]);
  });

  it("hands on what arrives", async () => {
    await world.live();
    world.seen = [];
    world.say({ case: "frame", value: create(FrameSchema) });
    world.say({ case: "still", value: create(StillSchema) });
    world.say({ case: "slice", value: create(ExactSliceSchema) });
    world.say({ case: "slicesStale", value: create(SlicesStaleSchema) });
    world.say({ case: "problem", value: create(ProblemSchema) });
    world.say({ case: "fileProgress", value: create(FileProgressSchema, { done: 0.5 }) });
    world.say({ case: "filePart", value: create(FilePartSchema, { seq: 2n }) });
    expect(world.seen).toEqual(["frame", "still", "slice", "slices stale", "problem", "file 0.5", "part 2"]);
  });

  it("drops the scene that was waiting for the next screen refresh when it becomes a follower", async () => {
    await world.live(1, 0);
    world.client.setScene(scene(5));
    world.client.setScene(scene(6));
    world.config(9, 3, true);
    world.screen();
    expect(world.updates()).toEqual([{ seq: 1, x: 5 }]);
  });

  it("sends scenes once it is the presenter, and no longer when the role moves on", async () => {
    await world.live(1, 0);
    world.config(9, 3, true);
    audience("ann");
    audience("me");
    world.client.setScene(scene(6));
    expect(world.updates().at(-1)?.x).toBe(6);
    audience("ann");
    world.client.setScene(scene(7));
    world.screen();
    expect(world.updates().at(-1)?.x).toBe(6);
    world.client.handOver("ann");
    expect(world.sent.at(-1)?.body).toMatchObject({ case: "handover", value: { to: "ann" } });
  });

  it("returns to its free camera after a reconnection", async () => {
    await world.live(1, 0);
    world.config(9, 3, true);
    world.client.useFreeCamera(true);
    world.config(9, 0, false);
    audience("ann", true);
    world.client.setScene(scene(44));
    world.screen();
    world.sockets.at(-1)?.closed(4503);
    world.timeout();
    await Promise.resolve();
    await Promise.resolve();
    world.sockets.at(-1)?.opened();
    world.config(9, 3, true);
    expect(world.sent.at(-1)?.body).toMatchObject({ case: "freeCamera", value: { on: true } });
    world.config(9, 0, false);
    world.screen();
    expect(world.updates().at(-1)?.x).toBe(44);
  });
});
