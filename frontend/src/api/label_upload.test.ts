import { beforeEach, describe, expect, it, vi } from "vitest";
import { ApiProblem } from "./client";
import { LabelUpload, type LabelUploadEvents } from "./label_upload";
import type { DataSet } from "./types";
import { startUpload, type UploadEvents } from "./upload";

vi.mock(import("./upload"), async (original) => ({ ...(await original()), startUpload: vi.fn() }));

/** The uploads that were started, by their URL. */
let started: { readonly url: string; readonly events: UploadEvents; readonly resume: () => void }[] = [];
let announcements = 0;
let answer: () => Promise<{ data_set: DataSet; upload_url: string }>;
let kept: Map<string, string>;
let online: (() => void) | null = null;

const store = {
  getItem: (key: string) => kept.get(key) ?? null,
  setItem: (key: string, value: string) => void kept.set(key, value),
};
const api = {
  csrfToken: "c",
  addLabels: () => {
    announcements += 1;
    return answer();
  },
};

beforeEach(() => {
  started = [];
  announcements = 0;
  kept = new Map();
  vi.stubGlobal("addEventListener", (_: "online", call: () => void) => (online = call));
  vi.stubGlobal("removeEventListener", () => (online = null));
  answer = () => Promise.resolve({ data_set: { labels: null } as DataSet, upload_url: `/v1/uploads/${announcements}` });
  vi.mocked(startUpload).mockImplementation((_bundle, url, _token, events) => {
    const resume = vi.fn();
    started.push({ url, events, resume });
    return { stop: () => undefined, resume };
  });
  vi.useFakeTimers({ toFake: ["setTimeout", "clearTimeout"] });
});

function eventsOf() {
  return {
    announced: vi.fn<LabelUploadEvents["announced"]>(),
    progress: vi.fn<LabelUploadEvents["progress"]>(),
    stalled: vi.fn<LabelUploadEvents["stalled"]>(),
    done: vi.fn<LabelUploadEvents["done"]>(),
    failed: vi.fn<LabelUploadEvents["failed"]>(),
  };
}

const begin = (content: string, events = eventsOf(), scan = "scan") => ({
  events,
  upload: new LabelUpload(api, store, scan, new Blob([content]), events),
});
const waitStarted = (count: number) => vi.waitFor(() => expect(started).toHaveLength(count));

describe("an upload of labels", () => {
  it("resumes where it stopped if the same file is chosen again", async () => {
    const first = begin("organs");
    await waitStarted(1);
    first.upload.stop();
    const second = begin("organs");
    await waitStarted(2);
    expect(started.map(({ url }) => url)).toEqual(["/v1/uploads/1", "/v1/uploads/1"]);
    expect(announcements).toBe(1);
    started[1]?.events.end({ kind: "done" });
    expect(second.events.done).toHaveBeenCalledOnce();
    begin("organs");
    await waitStarted(3);
    expect(announcements, "the upload is complete").toBe(2);
  });

  it("does not continue with another file of the same length, or for another scan", async () => {
    begin("organs");
    await waitStarted(1);
    begin("orgaNs");
    await waitStarted(2);
    begin("organs", eventsOf(), "other scan");
    await waitStarted(3);
    expect(announcements).toBe(3);
  });

  it.each([404, 410])("is announced again if the server no longer has it (%i)", async (status) => {
    begin("organs");
    await waitStarted(1);
    const { events } = begin("organs");
    await waitStarted(2);
    started[1]?.events.end({ kind: "refused", status });
    await waitStarted(3);
    expect(started[2]?.url).toBe("/v1/uploads/2");
    started[2]?.events.end({ kind: "refused", status });
    expect(events.failed, "a new one that is gone is not announced again and again").toHaveBeenCalledOnce();
  });

  it("is announced again after a network failure, and says so meanwhile", async () => {
    const works = answer;
    answer = () => Promise.reject(new ApiProblem(0, "offline", ""));
    const { events } = begin("organs");
    await vi.waitFor(() => expect(events.stalled).toHaveBeenCalledWith("connection"));
    answer = works;
    await vi.advanceTimersByTimeAsync(3000);
    await waitStarted(1);
    expect(events.failed).not.toHaveBeenCalled();
  });

  it("resumes at once when the network is back, until it is stopped", async () => {
    const { upload } = begin("organs");
    await waitStarted(1);
    online?.();
    expect(started[0]?.resume).toHaveBeenCalledOnce();
    upload.stop();
    expect(online).toBeNull();
  });

  it("is not repeated if the server refuses it", async () => {
    answer = () => Promise.reject(new ApiProblem(409, "conflict", ""));
    const { events } = begin("organs");
    await vi.waitFor(() => expect(events.failed).toHaveBeenCalledOnce());
    await vi.advanceTimersByTimeAsync(60_000);
    expect(announcements).toBe(1);
  });
});
