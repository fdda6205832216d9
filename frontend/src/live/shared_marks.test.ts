import { create, fromBinary } from "@bufbuild/protobuf";
import { signal } from "@preact/signals";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { vec3 } from "../input/vec3";
import { newMark } from "../marks/mark";
import { Marks } from "../marks/marks";
import type { Audience } from "../protocol/messages";
import {
  AudienceSchema,
  ClientMessageSchema,
  Mark_Kind as Kind,
  MarkSightSchema,
  ParticipantSchema,
  SharedStateSchema,
  type ClientMessage,
} from "../protocol/gen/api/proto/stream_pb";
import { SharedMarks, sightEveryMs } from "./shared_marks";

const after = (ms: number, task: () => void) => {
  const timer = setTimeout(task, ms);
  return () => clearTimeout(timer);
};

describe("shared marks", () => {
  let said: ClientMessage["body"][] = [];
  const marks = new Marks();
  const audience = signal<Audience | null>(null);
  const view = signal<number | null>(null);
  let shared: SharedMarks;

  beforeEach(() => {
    vi.useFakeTimers();
    said = [];
    marks.replace([]);
    marks.others.value = new Map();
    marks.hidden.value = new Set();
    view.value = null;
    audience.value = audienceOf("owner", true);
    const say = (message: Uint8Array) => said.push(fromBinary(ClientMessageSchema, message).body) > 0;
    shared = new SharedMarks({ say, after, marks, audience, view });
    shared.connected();
  });
  afterEach(() => {
    shared.stop();
    vi.useRealTimers();
  });

  const audienceOf = (you: string, guestPointers: boolean): Audience =>
    create(AudienceSchema, {
      you,
      presenter: "owner",
      guestPointers,
      participants: ["owner", "guest"].map((id, number) =>
        create(ParticipantSchema, { id, number, owner: id === "owner", presenter: id === "owner" }),
      ),
    });
  const cases = () => said.splice(0).map((body) => body.case);
  const add = () => marks.add(newMark("text", vec3(1, 2, 3), 0));

  it("are sent when they change, again to a new worker, and removed", () => {
    expect(cases()).toEqual([]);
    add();
    expect(cases()).toEqual(["marks", "markSight"]);
    vi.advanceTimersByTime(1000);
    shared.connected();
    expect(cases()).toEqual(["marks", "markSight"]);
    vi.advanceTimersByTime(1000);
    marks.remove(1);
    expect(said[0]?.case === "marks" && said[0].value.items).toEqual([]);
  });

  it("are not shown while the viewer hides them, or the presenter turned those of guests off", () => {
    add();
    said = [];
    vi.advanceTimersByTime(1000);
    marks.shown.value = false;
    expect(said[0]?.case === "marks" && said[0].value.items).toEqual([]);
    marks.shown.value = true;
    vi.advanceTimersByTime(1000);
    audience.value = audienceOf("guest", false);
    said = [];
    add();
    vi.advanceTimersByTime(1000);
    expect(cases()).not.toContain("marks");
  });

  it("of the others are shown until they are removed or their author leaves", () => {
    const receive = (number: number, ids: number[]) =>
      shared.receive(
        create(SharedStateSchema, {
          marks: [{ number, marks: { items: ids.map((id) => ({ id, kind: Kind.TEXT })) } }],
        }),
      );
    receive(1, [4, 5]);
    expect(marks.othersList.value.map(({ number, mark }) => [number, mark.id])).toEqual([
      [1, 4],
      [1, 5],
    ]);
    receive(1, []);
    expect(marks.others.value.size).toBe(0);
    receive(1, [4]);
    shared.audienceChanged(create(AudienceSchema, { participants: [] }));
    expect(marks.others.value.size).toBe(0);
  });

  it("ask which are hidden with each view, but not more often than the worker answers", () => {
    add();
    vi.advanceTimersByTime(1000);
    said = [];
    for (let epoch = 1; epoch <= 10; epoch++) {
      view.value = epoch;
      vi.advanceTimersByTime(sightEveryMs / 5);
    }
    vi.advanceTimersByTime(1000);
    expect(cases()).toEqual(["markSight", "markSight", "markSight"]);
    shared.receiveSight(create(MarkSightSchema, { hidden: [{ number: 1, ids: [4] }] }));
    expect([...marks.hidden.value]).toEqual(["1.4"]);
  });
});
