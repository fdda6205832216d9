import { describe, expect, it } from "vitest";
import { sceneToJson } from "../protocol/messages";
import { someScene } from "../scene/testing";
import { delaysFrom, findingsOf } from "./check";
import { freeId, templates, textIn, withText, type Definition, type Step, type View } from "./definition";
import { withStepView } from "./materials";
import { withRegion } from "./region";
import { newDefinition, newStep } from "./templates";

const now = Date.parse("2026-11-28T08:00:00Z");
const view: View = {
  data_set_id: "0123abcd-0000-4000-8000-000000000000",
  scene: JSON.parse(sceneToJson(someScene())) as object,
  preset: "Bone",
  may_change: ["camera"],
  start: "random",
  region: { name: { en: "Knee" }, centre: [900, 0, 0], radius: 20 },
};
const complete = (step: Step): Step =>
  step.kind === "rating" || step.kind === "colours" || step.kind === "viewpoint" || step.kind === "latency"
    ? withStepView(step, view)
    : step;
const withSteps = async (...steps: Step[]): Promise<Definition> => {
  const study = await newDefinition("own", now);
  return { ...study, steps: [...study.steps.slice(0, 1), ...steps] };
};
const problemsOf = async (...steps: Step[]) => findingsOf(await withSteps(...steps), now).map(({ problem }) => problem);
const text = { en: "Words" };

describe("a template", () => {
  it.each(templates)("%s can be saved once its pictures are chosen", async (template) => {
    const study = await newDefinition(template, now);
    expect(study.steps[0]).toMatchObject({ id: "consent", kind: "consent" });
    expect(new Set(study.steps.map(({ id }) => id)).size).toBe(study.steps.length);
    const missing = findingsOf(study, now).map(({ problem }) => problem);
    expect(missing.every((problem) => ["view", "materials"].includes(problem))).toBe(true);
    expect(findingsOf({ ...study, steps: study.steps.map(complete) }, now)).toEqual([]);
    for (const step of study.steps) {
      expect(textIn(step.text, "en").lang).toBe("en");
      expect(textIn(step.text, "de").lang).toBe("de");
    }
  });

  it("asks the ten questions of the SUS from 1 to 5", async () => {
    const { steps } = await newDefinition("sus", now);
    const questions = steps.filter((step) => step.kind === "rating");
    expect(questions.map(({ id }) => id)).toEqual(Array.from({ length: 10 }, (_, i) => `sus-${i + 1}`));
    expect(questions.every(({ low, high }) => low === 1 && high === 5)).toBe(true);
  });
});

describe("the check of a study", () => {
  it("finds what is wrong with the study as a whole", async () => {
    const study = await withSteps({ ...newStep("text", "a"), text });
    const found = (change: Partial<Definition>) =>
      findingsOf({ ...study, ...change }, now).map(({ problem }) => problem);
    expect(found({})).toEqual([]);
    expect(found({ title: { en: " " } })).toEqual(["title"]);
    expect(found({ title: { en: "x".repeat(121) } })).toEqual(["titleLong"]);
    for (const places of [0, 1001, 1.5, Number.NaN]) expect(found({ places })).toEqual(["places"]);
    for (const days of [-1, 366])
      expect(found({ ends_at: new Date(now + days * 86_400_000).toISOString() })).toEqual(["end"]);
    expect(found({ ends_at: "" })).toEqual(["end"]);
    expect(found({ steps: study.steps.slice(0, 1) })).toEqual(["steps"]);
    const large = { ...view, scene: { text: "x".repeat(1_100_000) } };
    expect(found({ steps: [...study.steps, { ...newStep("viewpoint", "v"), text, view: large } as Step] })).toContain(
      "large",
    );
  });

  it("finds what is wrong with a step", async () => {
    expect(await problemsOf(newStep("text", "a"))).toEqual(["text"]);
    expect(await problemsOf({ ...newStep("text", "a"), text: { de: "x".repeat(2001) } })).toEqual(["textLong"]);
    expect(await problemsOf({ ...newStep("viewpoint", "a"), text })).toEqual(["view"]);
    expect(await problemsOf({ ...newStep("rating", "a"), text })).toEqual(["labels"]);
    const labelled = { ...newStep("rating", "a"), text, low_text: text, high_text: text } as Step;
    expect(await problemsOf(labelled)).toEqual([]);
    const nameless = { ...view, region: { name: {}, centre: [900, 0, 0] as const, radius: 20 } };
    expect(await problemsOf({ ...newStep("viewpoint", "a"), text, view: nameless } as Step)).toEqual(["regionName"]);
    expect(await problemsOf({ ...labelled, low: 5, high: 5 } as Step)).toEqual(["scale"]);
    expect(await problemsOf({ ...newStep("choice", "a"), text })).toEqual(["options"]);
    expect(await problemsOf({ ...newStep("order", "a"), text, pictures: [] } as Step)).toEqual(["pictures"]);
    expect(await problemsOf({ ...newStep("latency", "a"), text, view, delays_ms: [500] } as Step)).toEqual(["delays"]);
  });

  it("wants a latency task to have a part that can face the viewer", async () => {
    const { region, ...plain } = view;
    const latency = (one: View) => ({ ...newStep("latency", "a"), text, view: one }) as Step;
    const atTarget = { ...view, region: { name: text, centre: [0, 0, 0] as const, radius: region?.radius ?? 1 } };
    const target = someScene().camera?.target;
    expect(target).toMatchObject({ x: 0, y: 0, z: 0 });
    expect(await problemsOf(latency(view))).toEqual([]);
    expect(await problemsOf(latency(plain))).toEqual(["region"]);
    expect(await problemsOf(latency({ ...view, start: "preset" }))).toEqual(["start"]);
    const copied = withStepView(newStep("latency", "a") as never, { ...view, start: "preset" });
    expect(await problemsOf({ ...copied, text })).toEqual([]);
    expect(await problemsOf(latency(atTarget))).toEqual(["regionAtTarget"]);
  });

  it("allows at most 20 pictures in a study", async () => {
    const orders = Array.from({ length: 5 }, (_, i) => ({ ...newStep("order", `o${i}`), text }));
    expect(await problemsOf(...orders)).toEqual(["studyPictures"]);
    expect(await problemsOf(...orders.slice(1))).toEqual([]);
  });
});

describe("the parts of a study", () => {
  it("reads delays, and refuses those out of range", () => {
    expect(delaysFrom("0, 50;100 400")).toEqual([0, 50, 100, 400]);
    for (const wrong of ["", "a", "-1", "401", "1.5", Array(21).fill("1").join()]) expect(delaysFrom(wrong)).toBeNull();
  });

  it("shows a text in the other language if there is none in this one", () => {
    expect(textIn({ de: "Hallo" }, "en")).toEqual({ text: "Hallo", lang: "de" });
    expect(textIn({ en: "Hello", de: " " }, "de")).toEqual({ text: "Hello", lang: "en" });
    expect(withText({ en: "a", de: "b" }, "de", "")).toEqual({ en: "a" });
    expect(withText({}, "de", "b")).toEqual({ de: "b" });
  });

  it("gives each new step an ID of its own", () => {
    expect(freeId(["text"], "rating")).toBe("rating");
    expect(freeId(["rating", "rating-2"], "rating")).toBe("rating-3");
  });

  it("keeps the materials that another picture shows, and drops the others", () => {
    const colours = { ...newStep("colours", "c"), materials: [{ channel: "gone", name: { en: "Gone" } }] } as Step;
    expect(withStepView(colours as never, view)).toMatchObject({ materials: [{ channel: "bone" }] });
    const kept = { ...newStep("colours", "c"), materials: [{ channel: "muscle", name: { en: "Meat" } }] } as Step;
    expect(withStepView(kept as never, view)).toMatchObject({
      materials: [{ channel: "muscle", name: { en: "Meat" } }],
    });
  });

  it("highlights a region, and changes nothing if it is shown already", () => {
    const scene = withRegion(someScene(), view.region ?? null);
    expect(scene.highlight).toMatchObject({ centre: { x: 900, y: 0, z: 0 }, radius: 20 });
    expect(withRegion(scene, view.region ?? null)).toBe(scene);
    expect(withRegion(scene, null).highlight).toBeUndefined();
    const plain = someScene();
    expect(withRegion(plain, null)).toBe(plain);
  });
});
