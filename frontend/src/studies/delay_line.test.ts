import { beforeEach, expect, it } from "vitest";
import type { SocketEvents } from "../protocol/stream_client";
import { DelayLine } from "./delay_line";

/** A clock whose timers fire in order when it is advanced. */
class FakeClock {
  now = 0;
  private timers: { readonly at: number; readonly task: () => void }[] = [];
  readonly nowMs = () => this.now;
  readonly after = (ms: number, task: () => void) => {
    const timer = { at: this.now + ms, task };
    this.timers.push(timer);
    return () => void (this.timers = this.timers.filter((one) => one !== timer));
  };

  advance(to: number): void {
    for (;;) {
      const next = this.timers.filter(({ at }) => at <= to).sort((a, b) => a.at - b.at)[0];
      if (!next) break;
      this.timers = this.timers.filter((one) => one !== next);
      this.now = next.at;
      next.task();
    }
    this.now = to;
  }
}

let clock: FakeClock;
let line: DelayLine;
let events: SocketEvents;
let got: string[];
let sent: Uint8Array[];

beforeEach(() => {
  clock = new FakeClock();
  line = new DelayLine(clock);
  got = [];
  sent = [];
  const open = line.around((_url, given) => {
    events = given;
    return { send: (data) => sent.push(data), close: () => undefined };
  });
  const socket = open("/stream", {
    opened: () => got.push(`${clock.now} opened`),
    message: ([first = 0]) => got.push(`${clock.now} message ${first}`),
    closed: (code) => got.push(`${clock.now} closed ${code}`),
  });
  socket.send(new Uint8Array([9]));
});

const message = (n: number) => events.message(new Uint8Array([n]));

it("passes messages on at once without a delay, and never holds what is sent", () => {
  events.opened();
  message(1);
  expect(got).toEqual(["0 opened", "0 message 1"]);
  expect(sent).toHaveLength(1);
});

it("holds each message for the delay, in order", () => {
  line.delayMs = 200;
  message(1);
  clock.advance(30);
  message(2);
  message(3);
  clock.advance(199);
  expect(got).toEqual([]);
  clock.advance(500);
  expect(got).toEqual(["200 message 1", "230 message 2", "230 message 3"]);
});

it("lets no message overtake an earlier one when the delay falls", () => {
  line.delayMs = 400;
  message(1);
  clock.advance(10);
  line.delayMs = 0;
  message(2);
  clock.advance(1000);
  expect(got).toEqual(["400 message 1", "400 message 2"]);
  message(3);
  expect(got.at(-1)).toBe("1000 message 3");
});

it("reports the end of a stream after its messages", () => {
  line.delayMs = 50;
  message(1);
  events.closed(1006);
  clock.advance(60);
  expect(got).toEqual(["50 message 1", "50 closed 1006"]);
});
