import { describe, expect, it } from "vitest";
import { de } from "./de";
import { studyTemplates as germanTemplates } from "./de/study_templates";
import { en } from "./en/en";
import { studyTemplates as englishTemplates } from "./en/study_templates";

type Node = Readonly<Record<string, unknown>>;
const isNode = (value: unknown): value is Node => typeof value === "object" && value !== null;

/** Every text by its path, such as "account.email", with its type and, for a function, the number of its arguments. */
function leaves(value: unknown, path: string): [string, string][] {
  if (isNode(value))
    return Object.entries(value).flatMap(([key, one]) => leaves(one, path === "" ? key : `${path}.${key}`));
  return [[path, typeof value]];
}
const shape = (catalogue: unknown) => Object.fromEntries(leaves(catalogue, ""));

function texts(value: unknown, path = ""): [string, string][] {
  if (typeof value === "string") return [[path, value]];
  return isNode(value) ? Object.entries(value).flatMap(([key, one]) => texts(one, `${path}.${key}`)) : [];
}

describe("the German catalogue", () => {
  it("has the same keys as the English one, also where the keys are data", () => {
    expect(shape(de)).toEqual(shape(en));
  });
  it("has the same texts for new studies as the English one, and none that is still English", () => {
    expect(shape(germanTemplates)).toEqual(shape(englishTemplates));
    const said = new Map(texts(englishTemplates));
    expect(texts(germanTemplates).filter(([path, text]) => text === "" || text === said.get(path))).toEqual([]);
  });
  it("has no empty text where English has one", () => {
    const said = new Map(texts(en));
    expect(texts(de).filter(([path, text]) => (text.trim() === "") !== ((said.get(path) ?? "").trim() === ""))).toEqual(
      [],
    );
  });
  it("contains no sentence that is still English", () => {
    const said = new Map(texts(en));
    expect(texts(de).filter(([path, text]) => text.split(" ").length > 2 && text === said.get(path))).toEqual([]);
  });
  it("formats numbers as in German, and has a singular", () => {
    expect(de.viewer.seconds(1.5)).toBe("1,5 s");
    expect(de.viewer.percent(0.0123)).toBe("1,2 %");
    expect(de.viewer.lossless(4096)).toBe("Verlustfrei, 4.096 Samples");
    expect(de.kernel.device("8 CPU threads (AVX2), no GPU: no driver")).toBe(
      "8 CPU-Threads (AVX2), keine GPU: no driver",
    );
    expect(de.add.slices(1)).toBe("1 Schicht");
    expect(de.add.slices(12_345)).toBe("12.345 Schichten");
  });
  it("addresses the user as Sie", () => {
    expect(texts(de).filter(([, text]) => /\b(du|dich|dir|dein|deine|deinen|deinem|deiner)\b/i.test(text))).toEqual([]);
  });
});
