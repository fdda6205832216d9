import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Api, ApiProblem } from "./client";
import { checksumOf } from "./upload";
import { forgetUpload, rememberUpload, rememberedUpload } from "./upload_memory";

const me = { id: "1", email: "a@example.org", csrf_token: "c".repeat(64), quota: { bytes: 1, used_bytes: 0 } };
let calls: { path: string; method: string; csrf: string | null; body: string | null }[] = [];
let answers: (() => Response)[] = [];

beforeEach(() => {
  calls = [];
  answers = [];
  vi.stubGlobal("fetch", (path: string, init: RequestInit) => {
    const headers = new Headers(init.headers);
    calls.push({
      path,
      method: init.method ?? "",
      csrf: headers.get("X-CSRF-Token"),
      body: typeof init.body === "string" ? init.body : null,
    });
    const answer = answers.shift();
    return answer ? Promise.resolve(answer()) : Promise.reject(new TypeError("offline"));
  });
});
afterEach(() => vi.unstubAllGlobals());

const json =
  (value: unknown, status = 200, headers = {}) =>
  () =>
    new Response(JSON.stringify(value), { status, headers });

describe("the REST client", () => {
  it("sends the CSRF token only with unsafe methods", async () => {
    answers = [json(me), json({ items: [], next_cursor: null }), () => new Response(null, { status: 204 })];
    const api = new Api();
    await api.signIn("a@example.org", "p");
    await api.dataSets();
    await api.deleteDataSet("7");
    expect(calls.map(({ csrf }) => csrf)).toEqual([null, null, me.csrf_token]);
  });

  it("reads a list page by page", async () => {
    answers = [json({ items: [1], next_cursor: "a&b" }), json({ items: [2], next_cursor: null })];
    expect(await new Api().dataSets()).toEqual([1, 2]);
    expect(calls[1]?.path).toBe("/v1/data-sets?cursor=a%26b");
  });

  it("turns a problem document into an ApiProblem", async () => {
    answers = [
      json(
        { type: "urn:diaphane:problem:over-quota", title: "t", status: 413, detail: "too much", request_id: "x" },
        413,
        { "Retry-After": "3" },
      ),
    ];
    const problem = await new Api().createDataSet("", 1, 1, "k").catch((thrown: unknown) => thrown);
    expect(problem).toMatchObject({ status: 413, kind: "over-quota", detail: "too much", retryAfterMs: 3000 });
  });

  it("recognises a foreign response, and a missing one", async () => {
    answers = [() => new Response("<html>", { status: 502 })];
    await expect(new Api().me()).rejects.toMatchObject({ status: 502, kind: "internal" });
    await expect(new Api().me()).rejects.toBeInstanceOf(ApiProblem);
    await expect(new Api().me()).rejects.toMatchObject({ status: 0, kind: "offline" });
  });

  it("does not treat a missing sign-in as an error", async () => {
    answers = [json({ type: "urn:diaphane:problem:unauthenticated", title: "", status: 401, request_id: "" }, 401)];
    expect(await new Api().me()).toBeNull();
  });
});

describe("an upload", () => {
  it("has the SHA-1 checksum of each part, as tus specifies", async () => {
    expect(await checksumOf(new Blob(["hello world"]))).toBe("sha1 Kq5sNclPz7QV2+lfQIuc6R7oRu0=");
  });

  it("is remembered by its fingerprint, forgotten by its ID, and only the newest twenty are kept", () => {
    const kept = new Map<string, string>();
    const store = {
      getItem: (key: string) => kept.get(key) ?? null,
      setItem: (key: string, value: string) => void kept.set(key, value),
    };
    for (let i = 0; i < 25; i++)
      rememberUpload(store, `print${i}`, { data_set_id: `d${i}`, upload_url: "/u", bytes: i });
    expect(rememberedUpload(store, "print4")).toBeNull();
    expect(rememberedUpload(store, "print24")).toEqual({ data_set_id: "d24", upload_url: "/u", bytes: 24 });
    forgetUpload(store, "d24");
    expect(rememberedUpload(store, "print24")).toBeNull();
    kept.set("diaphane.uploads", "{broken");
    expect(rememberedUpload(store, "print23")).toBeNull();
  });
});
