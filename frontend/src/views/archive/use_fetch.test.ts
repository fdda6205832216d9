import { beforeAll, expect, test } from "vitest";
import type { Fetch } from "../../api/archives";
import { loadTexts, t } from "../../texts";
import { fetchFault, progressOf } from "./use_fetch";

beforeAll(() => loadTexts("en"));

const fetch = (change: Partial<Fetch>): Fetch => ({
  id: "1",
  state: "fetching",
  images: 0,
  total: 0,
  uploaded: 0,
  data_set_id: null,
  problem: null,
  ...change,
});

test("the progress only grows from the first image to the end of the upload", () => {
  expect(progressOf(fetch({}))).toBeNull();
  const steps = [
    fetch({ total: 100 }),
    fetch({ total: 100, images: 50 }),
    fetch({ total: 100, images: 100 }),
    fetch({ total: 100, images: 100, state: "uploading" }),
    fetch({ total: 100, images: 100, state: "uploading", uploaded: 1 }),
  ].map((step) => progressOf(step) ?? -1);
  expect(steps).toEqual([...steps].sort((a, b) => a - b));
  expect(steps.at(0)).toBe(0);
  expect(steps.at(-1)).toBe(1);
});

test("each reason for a failure has a sentence that says what to do", () => {
  for (const kind of ["unreachable", "slow", "unauthorised", "faulty", "invalid", "not-found"])
    expect(fetchFault(kind)).toBe((t.archive.problems as Record<string, string>)[kind]);
  expect(fetchFault("over-quota")).toBe(t.problems.kinds["over-quota"]);
  expect(fetchFault("anything")).toBe(t.problems.internal);
});
