import { readdirSync, readFileSync } from "node:fs";
import { expect, test } from "vitest";
import { admin as de } from "./de/admin";
import { admin as en } from "./en/admin";

const root = new URL("../../../", import.meta.url);
const sources = (folder: string) =>
  readdirSync(new URL(folder, root), { recursive: true, encoding: "utf8" })
    .filter((name) => name.endsWith(".cpp") && !name.includes("_test"))
    .map((name) => readFileSync(new URL(folder + name, root), "utf8"));

test("each action in the server's audit log has a text in each language", () => {
  const action =
    /["']((?:accounts?|administrator|archive(?:-access)?|audit-log|data-set|preset|reports?)\.[a-z-]+)["']/g;
  const texts = ["api/", "ingest/pipeline/"].flatMap(sources);
  const names = [...new Set(texts.flatMap((text) => [...text.matchAll(action)].map(([, name]) => name ?? "")))].sort();
  expect(names.length).toBeGreaterThan(20);
  expect(Object.keys(en.actions).sort()).toEqual(names);
  expect(Object.keys(de.actions).sort()).toEqual(names);
});
