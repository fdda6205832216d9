import { beforeEach, describe, expect, it, vi } from "vitest";
import { SilenceWatch } from "./silence_watch";

describe("the watch over a silent connection", () => {
  let reachable = true;
  let probes = 0;
  let lost = 0;
  let watch: SilenceWatch;

  beforeEach(() => {
    vi.useFakeTimers();
    reachable = true;
    probes = 0;
    lost = 0;
    watch = new SilenceWatch({
      probe: () => {
        probes += 1;
        return Promise.resolve(reachable);
      },
      after: (ms, task) => {
        const timer = setTimeout(task, ms);
        return () => clearTimeout(timer);
      },
      nowMs: () => Date.now(),
      lost: () => (lost += 1),
    });
    return () => vi.useRealTimers();
  });

  it("reports a loss within 3 s when an answer is due and the server can't be reached", async () => {
    reachable = false;
    watch.expect(true);
    await vi.advanceTimersByTimeAsync(3000);
    expect(lost).toBe(1);
  });

  it("does not probe a server that owes no answer or is sending", async () => {
    reachable = false;
    await vi.advanceTimersByTimeAsync(60_000);
    watch.expect(true);
    for (let i = 0; i < 20; ++i) {
      await vi.advanceTimersByTimeAsync(1000);
      watch.messageReceived();
    }
    watch.expect(false);
    await vi.advanceTimersByTimeAsync(60_000);
    expect({ probes, lost }).toEqual({ probes: 0, lost: 0 });
  });

  it("waits for a server that is slow, and probes it rarely", async () => {
    watch.expect(true);
    await vi.advanceTimersByTimeAsync(20_000);
    expect(lost).toBe(0);
    expect(probes).toBeGreaterThan(1);
    expect(probes).toBeLessThan(6);
  });

  it("probes immediately when the browser reports that it is offline", async () => {
    watch.check();
    await vi.advanceTimersByTimeAsync(0);
    expect(lost).toBe(0);
    reachable = false;
    watch.check();
    await vi.advanceTimersByTimeAsync(0);
    expect(lost).toBe(1);
  });

  it("keeps the connection when a message arrives while the probe fails", async () => {
    reachable = false;
    await vi.advanceTimersByTimeAsync(1);
    watch.check();
    watch.messageReceived();
    await vi.advanceTimersByTimeAsync(0);
    expect(lost).toBe(0);
  });
});
