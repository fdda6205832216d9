import { expect, test } from "vitest";
import { TabCoordinator, type BetweenWindows } from "./tab_coordinator";
import { begun, inPhase, type UploadView } from "./upload_view";

/** A browser with windows: words arrive at once, and a window that crashes loses its locks and says nothing. */
class Browser {
  private readonly held = new Map<string, FakeWindow>();
  private readonly windows: FakeWindow[] = [];
  nowMs = 0;

  constructor(readonly withLocks = true) {}

  open(): FakeWindow {
    const channel: NonNullable<BetweenWindows["channel"]> = {
      onmessage: null,
      postMessage: (data: unknown) => {
        for (const other of this.windows)
          if (other.channel !== channel)
            other.channel.onmessage?.call({} as BroadcastChannel, { data: structuredClone(data) } as MessageEvent);
      },
    };
    const opened: FakeWindow = { sends: [], channel, others: undefined as unknown as TabCoordinator };
    const locks = {
      request: async (name: string, _: LockOptions, granted: (lock: Lock | null) => unknown) => {
        if (this.held.has(name)) {
          await granted(null);
          return;
        }
        this.held.set(name, opened);
        await granted({ name, mode: "exclusive" });
        this.held.delete(name);
      },
      query: () => Promise.resolve({ held: [...this.held.keys()].map((name) => ({ name })) }),
    } as unknown as LockManager;
    this.windows.push(opened);
    opened.others = new TabCoordinator(
      () => undefined,
      () => opened.sends,
      {
        locks: this.withLocks ? locks : null,
        channel,
        nowMs: () => this.nowMs,
      },
    );
    return opened;
  }

  crash(gone: FakeWindow): void {
    this.windows.splice(this.windows.indexOf(gone), 1);
    for (const [name, holder] of this.held) if (holder === gone) this.held.delete(name);
  }
}

interface FakeWindow {
  sends: readonly UploadView[];
  readonly channel: NonNullable<BetweenWindows["channel"]>;
  others: TabCoordinator;
}

const upload = { ...inPhase(begun("a", 100), "sending"), sent: 40 };

for (const withLocks of [true, false]) {
  test(`a new window hears at once what the others send (${withLocks ? "with" : "without"} locks)`, () => {
    const browser = new Browser(withLocks);
    browser.open().sends = [upload];
    expect(browser.open().others.views()).toMatchObject([{ data_set_id: "a", sent: 40 }]);
  });

  test(`of two windows one sends, until it lets go (${withLocks ? "with" : "without"} locks)`, async () => {
    const browser = new Browser(withLocks);
    const [first, second] = [browser.open(), browser.open()];
    expect(await first.others.claim("a")).toBe(true);
    first.sends = [upload];
    first.others.broadcast();
    expect(await second.others.claim("a")).toBe(false);
    expect(await second.others.claim("b")).toBe(true);
    first.sends = [];
    first.others.release("a");
    expect(second.others.views()).toEqual([]);
    await Promise.resolve();
    expect(await second.others.claim("a")).toBe(true);
  });
}

test("a window that sends and sleeps is still the one that sends", async () => {
  const browser = new Browser();
  const [first, second] = [browser.open(), browser.open()];
  await first.others.claim("a");
  first.sends = [upload];
  first.others.broadcast();
  browser.nowMs = 3_600_000;
  await second.others.forgetClosedTabs();
  expect(second.others.views()).toHaveLength(1);
  expect(await second.others.claim("a")).toBe(false);
});

test("a window that does not know of it yet does not send it either", async () => {
  const browser = new Browser();
  const [first, second] = [browser.open(), browser.open()];
  const both = Promise.all([first.others.claim("a"), second.others.claim("a")]);
  expect((await both).filter((may) => may)).toHaveLength(1);
});

test("what a window sent that is gone without a word may be gone on with", async () => {
  const browser = new Browser();
  const [first, second] = [browser.open(), browser.open()];
  await first.others.claim("a");
  first.sends = [upload];
  first.others.broadcast();
  browser.crash(first);
  await second.others.forgetClosedTabs();
  expect(second.others.views()).toEqual([]);
  expect(await second.others.claim("a")).toBe(true);
});

test("without locks, silence tells that a window has gone", () => {
  const browser = new Browser(false);
  const [first, second] = [browser.open(), browser.open()];
  first.sends = [upload];
  first.others.broadcast();
  browser.nowMs = 11_000;
  expect(second.others.views()).toHaveLength(1);
  browser.nowMs = 13_000;
  expect(second.others.views()).toEqual([]);
});
