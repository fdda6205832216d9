import { describe, expect, it } from "vitest";
import { settled_after_ms, SizeTeller, told_every_ms } from "./canvas_size";

class Hours {
  now = 0;
  private tasks: { at: number; task: () => void }[] = [];
  readonly clock = {
    now_ms: () => this.now,
    after: (ms: number, task: () => void) => {
      const planned = { at: this.now + ms, task };
      this.tasks.push(planned);
      return () => (this.tasks = this.tasks.filter((one) => one !== planned));
    },
  };
  pass(ms: number): void {
    const end = this.now + ms;
    for (let next = this.next(end); next; next = this.next(end)) {
      this.now = next.at;
      this.tasks = this.tasks.filter((one) => one !== next);
      next.task();
    }
    this.now = end;
  }
  private next(end: number) {
    return this.tasks.filter((one) => one.at <= end).sort((a, b) => a.at - b.at)[0];
  }
}

describe("the size of the canvas", () => {
  it("is told once when it has settled", () => {
    const hours = new Hours();
    const told: number[] = [];
    const teller = new SizeTeller({ width: 100, height: 50 }, (size) => told.push(size.width), hours.clock);
    for (const width of [101, 102, 103]) {
      teller.changed({ width, height: 50 });
      hours.pass(16);
    }
    expect(told).toEqual([]);
    hours.pass(settled_after_ms);
    expect(told).toEqual([103]);
  });

  it("is told now and then while it keeps changing", () => {
    const hours = new Hours();
    const told: number[] = [];
    const teller = new SizeTeller({ width: 100, height: 50 }, (size) => told.push(size.width), hours.clock);
    for (let n = 1; n <= 100; n++) {
      teller.changed({ width: 100 + n, height: 50 });
      hours.pass(16);
    }
    expect(told.length).toBeGreaterThanOrEqual(Math.floor(1600 / (told_every_ms + 16)) - 1);
    expect(told.length).toBeLessThanOrEqual(Math.ceil(1600 / told_every_ms));
  });

  it("there and back is no change, and the first size is told by the greeting", () => {
    const hours = new Hours();
    const told: number[] = [];
    const teller = new SizeTeller({ width: 100, height: 50 }, (size) => told.push(size.width), hours.clock);
    teller.changed({ width: 100, height: 50 });
    teller.changed({ width: 90, height: 50 });
    teller.changed({ width: 100, height: 50 });
    hours.pass(1000);
    expect(told).toEqual([]);
  });
});
