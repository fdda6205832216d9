import { expect, test } from "vitest";
import { OtherWindows, type BetweenWindows } from "./other_windows";
import { begun, in_phase, type UploadView } from "./upload_view";

/** A browser with windows: words arrive at once, and a window that crashes loses its locks and says nothing. */
class Browser {
  private readonly held_ = new Map<string, FakeWindow>();
  private readonly windows_: FakeWindow[] = [];
  now_ms = 0;

  constructor(readonly with_locks = true) {}

  open(): FakeWindow {
    const channel: NonNullable<BetweenWindows["channel"]> = {
      onmessage: null,
      postMessage: (data: unknown) => {
        for (const other of this.windows_)
          if (other.channel !== channel) other.channel.onmessage?.call({} as BroadcastChannel, { data: structuredClone(data) } as MessageEvent);
      },
    };
    const opened: FakeWindow = { sends: [], channel, others: undefined as unknown as OtherWindows };
    const locks = {
      request: async (name: string, _: LockOptions, granted: (lock: Lock | null) => unknown) => {
        if (this.held_.has(name)) {
          await granted(null);
          return;
        }
        this.held_.set(name, opened);
        await granted({ name, mode: "exclusive" });
        this.held_.delete(name);
      },
      query: () => Promise.resolve({ held: [...this.held_.keys()].map((name) => ({ name })) }),
    } as unknown as LockManager;
    this.windows_.push(opened);
    opened.others = new OtherWindows(() => undefined, () => opened.sends, {
      locks: this.with_locks ? locks : null, channel, now_ms: () => this.now_ms,
    });
    return opened;
  }

  crash(gone: FakeWindow): void {
    this.windows_.splice(this.windows_.indexOf(gone), 1);
    for (const [name, holder] of this.held_) if (holder === gone) this.held_.delete(name);
  }
}

interface FakeWindow {
  sends: readonly UploadView[];
  readonly channel: NonNullable<BetweenWindows["channel"]>;
  others: OtherWindows;
}

const upload = { ...in_phase(begun("a", 100), "sending"), sent: 40 };

for (const with_locks of [true, false]) {
  test(`a new window hears at once what the others send (${with_locks ? "with" : "without"} locks)`, () => {
    const browser = new Browser(with_locks);
    browser.open().sends = [upload];
    expect(browser.open().others.views()).toMatchObject([{ data_set_id: "a", sent: 40 }]);
  });

  test(`of two windows one sends, until it lets go (${with_locks ? "with" : "without"} locks)`, async () => {
    const browser = new Browser(with_locks);
    const [first, second] = [browser.open(), browser.open()];
    expect(await first.others.claim("a")).toBe(true);
    first.sends = [upload];
    first.others.tell();
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
  first.others.tell();
  browser.now_ms = 3_600_000;
  await second.others.look();
  expect(second.others.views()).toHaveLength(1);
  expect(await second.others.claim("a")).toBe(false);
});

test("who has not heard of it yet does not send it either", async () => {
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
  first.others.tell();
  browser.crash(first);
  await second.others.look();
  expect(second.others.views()).toEqual([]);
  expect(await second.others.claim("a")).toBe(true);
});

test("without locks, silence tells that a window has gone", () => {
  const browser = new Browser(false);
  const [first, second] = [browser.open(), browser.open()];
  first.sends = [upload];
  first.others.tell();
  browser.now_ms = 11_000;
  expect(second.others.views()).toHaveLength(1);
  browser.now_ms = 13_000;
  expect(second.others.views()).toEqual([]);
});
