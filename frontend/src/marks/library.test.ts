import { signal } from "@preact/signals";
import { beforeEach, describe, expect, it } from "vitest";
import type { AnnotationChange, AnnotationsApi, AnnotationSet } from "../api/annotations";
import { ApiProblem } from "../api/client";
import { vec3 } from "../input/vec3";
import { annotationsToJson } from "../protocol/mark_messages";
import type { Measure } from "../slices/measure";
import { MarkLibrary } from "./library";
import { newMark } from "./mark";
import { Marks } from "./marks";

const ruler: Measure = { kind: "ruler", plane: "axial", slice: 3, points: [vec3(0, 0, 0), vec3(1, 0, 0)] };
const contentOf = (texts: readonly string[]) =>
  annotationsToJson({
    marks: texts.map((text, i) => ({ ...newMark("text", vec3(i, 0, 0), 0), id: i, text })),
    measures: [],
  });
const setOf = (id: string, more: Partial<AnnotationSet> = {}): AnnotationSet => ({
  id,
  name: id,
  mine: true,
  shown: true,
  shared: false,
  content: contentOf([id]),
  revision: "1",
  ...more,
});

const problem412 = new ApiProblem(412, "precondition", "");

describe("saved marks", () => {
  let stored: AnnotationSet[] = [];
  let marks: Marks;
  let due: (() => void)[] = [];
  const slices = { measures: signal<readonly Measure[]>([]), following: signal(false) };
  const memory = { unsavedSets: [] as readonly string[], hiddenSets: [] as readonly string[] };
  const api = {
    add: (_: string, name: string, content: unknown) => {
      const added = setOf("new", { name, content });
      stored.push(added);
      return Promise.resolve(added);
    },
    change: (_: string, id: string, { revision, ...what }: AnnotationChange) => {
      const before = stored.find((one) => one.id === id);
      if (revision !== undefined && revision !== before?.revision) return Promise.reject(problem412);
      const next = what.content === undefined ? {} : { revision: `${Number(before?.revision) + 1}` };
      stored = stored.map((one) => (one.id === id ? { ...one, ...what, ...next } : one));
      return Promise.resolve(stored.find((one) => one.id === id));
    },
    remove: () => Promise.resolve(),
  } as unknown as AnnotationsApi;
  const opened = async () => {
    const library = new MarkLibrary({
      api,
      list: () => Promise.resolve([...stored]),
      dataSetId: "scan",
      marks,
      slices,
      memory,
      saves: true,
      shares: true,
      after: (_, task) => {
        due = [task];
        return () => (due = []);
      },
    });
    await library.load();
    return library;
  };
  const texts = () => marks.items.value.map(({ text }) => text);
  const saved = (id: string) => JSON.stringify(stored.find((one) => one.id === id)?.content);
  const settle = async () => {
    for (const task of due.splice(0)) task();
    await new Promise((done) => setTimeout(done));
  };

  beforeEach(() => {
    marks = new Marks();
    stored = [];
    due = [];
    slices.measures.value = [];
    slices.following.value = false;
    memory.unsavedSets = [];
    memory.hiddenSets = [];
  });

  it("are shown as the author left them, and changes are saved by themselves", async () => {
    stored = [setOf("a"), setOf("b", { shown: false })];
    const library = await opened();
    expect(texts()).toEqual(["a"]);
    marks.setText(1, "changed");
    expect(memory.unsavedSets).toEqual(["a"]);
    await settle();
    expect(saved("a")).toBe(JSON.stringify(contentOf(["changed"])));
    expect(memory.unsavedSets).toEqual([]);
    const [a] = library.sets.value ?? [];
    if (a) await library.setVisible(a, false);
    await settle();
    expect(texts()).toEqual([]);
    expect(saved("a"), "hiding deletes nothing").toBe(JSON.stringify(contentOf(["changed"])));
  });

  it("stay shown and are all tried if one of them cannot be saved", async () => {
    stored = [setOf("a"), setOf("b")];
    const library = await opened();
    marks.setText(1, "a changed");
    marks.setText(2, "b changed");
    const change = api.change.bind(api);
    api.change = (scan, id, what) =>
      id === "a" ? Promise.reject(new ApiProblem(503, "unavailable", "")) : change(scan, id, what);
    try {
      const [a] = library.sets.value ?? [];
      if (a) await library.setVisible(a, false);
    } finally {
      api.change = change;
    }
    expect(saved("b")).toBe(JSON.stringify(contentOf(["b changed"])));
    expect(library.failed.value).toBe(true);
    expect(texts(), "hiding it would lose the change").toContain("a changed");
    await library.save();
    expect(library.failed.value).toBe(false);
    expect(saved("a")).toBe(JSON.stringify(contentOf(["a changed"])));
  });

  it("take what was not saved yet, with its measurements", async () => {
    const library = await opened();
    marks.add({ ...newMark("text", vec3(0, 0, 0), 0), text: "x" });
    slices.measures.value = [ruler];
    await library.add("Mine");
    expect(library.unsaved()).toEqual({ marks: [], measures: [] });
    expect(slices.measures.value[0]?.set).toBe("new");
    expect(saved("new")).toContain("RULER");
    await settle();
    expect(due).toEqual([]);
  });

  it("keep what a reload interrupted, and otherwise show what the server has", async () => {
    stored = [setOf("a"), setOf("b")];
    marks.show("a", [{ ...newMark("text", vec3(0, 0, 0), 0), id: 1, text: "newer" }]);
    marks.show("b", [{ ...newMark("text", vec3(0, 0, 0), 0), id: 1, text: "older" }]);
    marks.show("gone", [{ ...newMark("text", vec3(0, 0, 0), 0), id: 1, text: "gone" }]);
    memory.unsavedSets = ["a"];
    const library = await opened();
    expect(texts().sort()).toEqual(["b", "gone", "newer"]);
    expect(library.unsaved().marks.map(({ text }) => text)).toEqual(["gone"]);
    await settle();
    expect(saved("a")).toBe(JSON.stringify(contentOf(["newer"])));
  });

  it("keep what two windows have changed", async () => {
    stored = [setOf("a", { content: contentOf(["first", "second", "third"]) })];
    await opened();
    stored = [
      setOf("a", {
        content: contentOf(["first", "second", "third, other window", "new, other window"]),
        revision: "2",
      }),
    ];
    marks.remove(1);
    marks.add({ ...newMark("text", vec3(9, 0, 0), 0), text: "new, this window" });
    const [last] = marks.items.value.slice(-1);
    marks.items.value = marks.items.value.map((mark) => (mark === last ? { ...mark, set: "a" } : mark));
    await settle();
    const all = ["second", "third, other window", "new, other window", "new, this window"];
    expect(texts()).toEqual(all);
    await settle();
    for (const text of all) expect(saved("a")).toContain(`"${text}"`);
    expect(saved("a")).not.toContain("first");
    expect(memory.unsavedSets).toEqual([]);
  });

  it("of the owner are neither changed nor saved, and stay hidden", async () => {
    stored = [setOf("theirs", { mine: false, shared: true })];
    const library = await opened();
    expect(marks.items.value.map((mark) => marks.isOwn(mark))).toEqual([false]);
    marks.setText(1, "changed");
    await settle();
    expect(saved("theirs")).toBe(JSON.stringify(contentOf(["theirs"])));
    const [theirs] = library.sets.value ?? [];
    if (theirs) await library.setVisible(theirs, false);
    marks = new Marks();
    await opened();
    expect(texts()).toEqual([]);
  });

  it("are not replaced by the presenter's measurements", async () => {
    stored = [setOf("a")];
    await opened();
    slices.following.value = true;
    slices.measures.value = [];
    marks.setText(1, "x");
    await settle();
    expect(saved("a")).toBe(JSON.stringify(contentOf(["a"])));
  });
});
