import { create, fromBinary } from "@bufbuild/protobuf";
import { signal } from "@preact/signals";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { vec3 } from "../input/vec3";
import {
  AnatomicalPlane,
  AudienceSchema,
  ClientMessageSchema,
  ParticipantSchema,
  SharedState_PointerSchema as PointerSchema,
  SharedStateSchema,
  SliceView_Layout as Layout,
  SliceViewSchema,
  type Audience,
  type ClientMessage,
} from "../protocol/gen/api/proto/stream_pb";
import { Slices } from "../slices/model";
import { axial, coronal, header, sagittal } from "../slices/testing";
import { Collaboration, pointerForMs, sharedEveryMs } from "./collaboration";

/** `presenter` and `you` are "owner" or "guest". */
function audienceOf(you: string, presenter: string, change: Partial<Audience> = {}): Audience {
  const participants = ["owner", "guest"].map((id, number) =>
    create(ParticipantSchema, { id, number, owner: id === "owner", presenter: id === presenter }),
  );
  return Object.assign(create(AudienceSchema, { you, presenter, participants, guestPointers: true }), change);
}

describe("what participants show each other", () => {
  let said: ClientMessage["body"][] = [];
  let slices: Slices;
  let collaboration: Collaboration;
  const audience = signal<Audience | null>(null);

  beforeEach(() => {
    vi.useFakeTimers();
    vi.stubGlobal("requestAnimationFrame", () => 0);
    said = [];
    audience.value = null;
    slices = new Slices(() => undefined);
    collaboration = new Collaboration({
      say: (message) => said.push(fromBinary(ClientMessageSchema, message).body) > 0,
      after: (ms, task) => {
        const timer = setTimeout(task, ms);
        return () => clearTimeout(timer);
      },
      slices,
      audience,
    });
    slices.configured([axial, sagittal, coronal], header);
    collaboration.connected();
  });
  afterEach(() => {
    collaboration.stop();
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });
  const join = (next: Audience) => {
    audience.value = next;
    slices.allow("whole");
    collaboration.audienceChanged(next);
  };
  const cases = () => said.map((body) => body.case);
  const shows = (view: Parameters<typeof create<typeof SliceViewSchema>>[1]) =>
    collaboration.receive(create(SharedStateSchema, { seq: 7n, sliceView: create(SliceViewSchema, view) }));

  it("is nothing while a viewer is alone", () => {
    const alone = audienceOf("owner", "owner");
    join({ ...alone, participants: alone.participants.slice(0, 1) });
    slices.open.value = true;
    slices.scroll(axial, 1);
    collaboration.point({ x: 0.5, y: 0.5 });
    vi.advanceTimersByTime(1000);
    expect(said).toEqual([]);
  });

  it("is the presenter's newest view of the slices, at most ten times per second", () => {
    join(audienceOf("owner", "owner"));
    expect(cases()).toEqual(["sliceView", "measurements"]);
    slices.open.value = true;
    for (let i = 0; i < 20; ++i) slices.setWindow({ centre: i, width: 100 });
    expect(said).toHaveLength(2);
    vi.advanceTimersByTime(sharedEveryMs);
    expect(said).toHaveLength(3);
    const last = said.at(-1);
    expect(last?.case === "sliceView" && [last.value.layout, last.value.windowCentre]).toEqual([Layout.FOUR, 19]);
  });

  it("is followed with the presenter's measurements, and the follower's own view returns", () => {
    join(audienceOf("guest", "owner"));
    slices.setWindow({ centre: 1, width: 10 });
    shows({
      layout: Layout.SLICE,
      plane: AnatomicalPlane.CORONAL,
      crosshair: { x: 1, y: 2, z: 3 },
      windowCentre: 300,
      windowWidth: 600,
    });
    expect(slices.following.value).toBe(true);
    expect(slices.view.value).toBe("coronal");
    expect(slices.crosshair.value).toEqual(vec3(1, 2, 3));
    expect(slices.remembered()?.window).toEqual({ centre: 1, width: 10 });
    vi.advanceTimersByTime(50);
    const last = said.at(-1);
    expect(last?.case === "sharedTaken" && last.value.seq).toBe(7n);
    shows({});
    expect(slices.following.value).toBe(false);
    expect(slices.open.value).toBe(false);
    expect(slices.window.value).toEqual({ centre: 1, width: 10 });
  });

  it("is not followed in one's own view, and a new presenter continues with it", () => {
    const own = audienceOf("guest", "owner");
    own.participants.forEach((one) => (one.freeCamera = one.id === "guest"));
    join(own);
    shows({ layout: Layout.FOUR, windowCentre: 300, windowWidth: 600 });
    expect(slices.following.value).toBe(false);
    join(audienceOf("guest", "owner"));
    expect(slices.following.value).toBe(true);
    said = [];
    join(audienceOf("guest", "guest"));
    expect(slices.following.value).toBe(false);
    expect(slices.open.value).toBe(true);
    const sent = said.find((body) => body.case === "sliceView");
    expect(sent?.case === "sliceView" && sent.value.windowCentre).toBe(300);
  });

  it("is sent again to another worker", () => {
    join(audienceOf("owner", "owner"));
    collaboration.setGuestPointers(false);
    vi.advanceTimersByTime(1000);
    said = [];
    collaboration.connected();
    join(audienceOf("owner", "owner"));
    expect(cases().sort()).toEqual(["guestPointers", "measurements", "sliceView"]);
  });

  it("contains pointers until they rest, leave, or are turned off", () => {
    join(audienceOf("owner", "owner"));
    const moves = (shown: boolean) =>
      collaboration.receive(
        create(SharedStateSchema, { pointers: [create(PointerSchema, { number: 1, shown, x: 5 })] }),
      );
    moves(true);
    expect(collaboration.pointers.value.get(1)).toEqual({ number: 1, plane: null, place: vec3(5, 0, 0) });
    moves(false);
    expect(collaboration.pointers.value.size).toBe(0);
    moves(true);
    vi.advanceTimersByTime(pointerForMs);
    expect(collaboration.pointers.value.size).toBe(0);
    moves(true);
    join(audienceOf("owner", "owner", { guestPointers: false }));
    expect(collaboration.pointers.value.size).toBe(0);
  });

  it("includes the pointer of a guest while the presenter allows it", () => {
    join(audienceOf("guest", "owner"));
    collaboration.point({ plane: "sagittal", place: vec3(1, 2, 3) });
    const sent = said.at(-1);
    expect(sent?.case === "pointer" && sent.value.at.case).toBe("slice");
    join(audienceOf("guest", "owner", { guestPointers: false }));
    said = [];
    collaboration.point({ x: 0.1, y: 0.2 });
    vi.advanceTimersByTime(1000);
    expect(said).toEqual([]);
  });
});
