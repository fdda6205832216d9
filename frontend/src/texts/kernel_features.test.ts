import { readFileSync } from "node:fs";
import { expect, test } from "vitest";
import { kernel as de } from "./de/kernel";
import { kernel as en } from "./en/kernel";

test("each feature that a renderer reports has a text in each language", () => {
  const header = readFileSync(new URL("../../../renderd/kernel/features.h", import.meta.url), "utf8");
  const list = /kFeatureNames\[kFeatureCount\] = \{([^}]*)\}/.exec(header)?.[1] ?? "";
  const names = [...list.matchAll(/"([^"]+)"/g)].map(([, name]) => name ?? "").sort();
  expect(names.length).toBeGreaterThan(10);
  expect(Object.keys(en.features).sort()).toEqual(names);
  expect(Object.keys(de.features).sort()).toEqual(names);
});
