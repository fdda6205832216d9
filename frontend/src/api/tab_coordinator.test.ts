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
  test(`a new tab learns immediately what the others send (${withLocks ? "with" : "without"} locks)`, () => {
    const browser = new Browser(withLocks);
    browser.open().sends = [upload];
    expect(browser.open().others.views()).toMatchObject([{ data_set_id: "a", sent: 40 }]);
  });

  test(`only one of two tabs sends, until it releases the upload (${withLocks ? "with" : "without"} locks)`, async () => {
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

test("a sending tab that sleeps keeps its upload", async () => {
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

test("a tab that does not know of an upload yet does not send it", async () => {
  const browser = new Browser();
  const [first, second] = [browser.open(), browser.open()];
  const both = Promise.all([first.others.claim("a"), second.others.claim("a")]);
  expect((await both).filter((may) => may)).toHaveLength(1);
});

test("the uploads of a tab that was closed can be resumed", async () => {
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

test("without locks, a silent tab counts as closed", () => {
  const browser = new Browser(false);
  const [first, second] = [browser.open(), browser.open()];
  first.sends = [upload];
  first.others.broadcast();
  browser.nowMs = 11_000;
  expect(second.others.views()).toHaveLength(1);
  browser.nowMs = 13_000;
  expect(second.others.views()).toEqual([]);
});
