import { describe, expect, it } from "vitest";
import { settledAfterMs, ResizeDebouncer, reportedEveryMs, snapped } from "./canvas_size";

class Hours {
  now = 0;
  private tasks: { at: number; task: () => void }[] = [];
  readonly clock = {
    nowMs: () => this.now,
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
  it("is reported once after it has stopped changing", () => {
    const hours = new Hours();
    const reported: number[] = [];
    const debouncer = new ResizeDebouncer({ width: 100, height: 50 }, (size) => reported.push(size.width), hours.clock);
    for (const width of [101, 102, 103]) {
      debouncer.changed({ width, height: 50 });
      hours.pass(16);
    }
    expect(reported).toEqual([]);
    hours.pass(settledAfterMs);
    expect(reported).toEqual([103]);
  });

  it("is reported from time to time while it keeps changing", () => {
    const hours = new Hours();
    const reported: number[] = [];
    const debouncer = new ResizeDebouncer({ width: 100, height: 50 }, (size) => reported.push(size.width), hours.clock);
    for (let n = 1; n <= 100; n++) {
      debouncer.changed({ width: 100 + n, height: 50 });
      hours.pass(16);
    }
    expect(reported.length).toBeGreaterThanOrEqual(Math.floor(1600 / (reportedEveryMs + 16)) - 1);
    expect(reported.length).toBeLessThanOrEqual(Math.ceil(1600 / reportedEveryMs));
  });

  it("is not reported if it returns to the previous one, and the greeting contains the first", () => {
    const hours = new Hours();
    const reported: number[] = [];
    const debouncer = new ResizeDebouncer({ width: 100, height: 50 }, (size) => reported.push(size.width), hours.clock);
    debouncer.changed({ width: 100, height: 50 });
    debouncer.changed({ width: 90, height: 50 });
    debouncer.changed({ width: 100, height: 50 });
    hours.pass(1000);
    expect(reported).toEqual([]);
  });
});

describe("the device pixels of a box", () => {
  it("are counted between its edges, each on the nearest pixel", () => {
    // 438.4 pixels high, from 67.2 to 505.6: 439 rows.
    expect(snapped({ left: 0, right: 960, top: 67.2, bottom: 505.6 }, 1)).toEqual({ width: 960, height: 439 });
    expect(snapped({ left: 0.3, right: 100.3, top: 0.3, bottom: 50.3 }, 2)).toEqual({ width: 200, height: 100 });
  });
});
