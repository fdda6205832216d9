import { expect, test } from "vitest";
import { comparePath, firstWords, routeOf } from "./routes";

test("an unknown path is not a page, whatever it begins with", () => {
  expect(routeOf("/nothing", "")).toEqual({ page: "not_found" });
  expect(routeOf("/constructor", "")).toEqual({ page: "not_found" });
  expect(routeOf("/view/../../etc", "")).toEqual({ page: "not_found" });
  for (const link of ["/join", "/shared", "/study"])
    expect(routeOf(link, "#short")).toEqual({ page: "incomplete_link" });
});

test("a secret is read from the fragment, and an ID from the path", () => {
  const secret = "0f".repeat(32);
  const id = "0123abcd-0000-4000-8000-000000000000";
  expect(routeOf("/join", `#${secret}`)).toEqual({ page: "join", token: secret });
  expect(routeOf("/verify", `#token=${secret}`)).toEqual({ page: "verify", token: secret });
  expect(routeOf(`/view/${id}`, "")).toEqual({ page: "view", dataSetId: id });
});

test("the sections of the administration have routes", () => {
  expect(routeOf("/admin", "")).toEqual({ page: "admin", part: "users" });
  expect(routeOf("/admin/audit", "")).toEqual({ page: "admin", part: "audit" });
  expect(routeOf("/admin/nothing", "")).toEqual({ page: "not_found" });
  expect(routeOf("/reset", "#token=abc")).toEqual({ page: "reset", token: "abc" });
});

test("every first word is a single path segment", () => {
  for (const word of firstWords) expect(word).toMatch(/^[a-z-]*$/);
});

test("the front page has its own route", () => {
  expect(routeOf("/", "")).toEqual({ page: "home" });
  expect(routeOf("/scans", "")).toEqual({ page: "scans" });
});

test("a study has a page for researchers and others for participants", () => {
  const secret = "0f".repeat(32);
  const id = "0123abcd-0000-4000-8000-000000000000";
  expect(routeOf("/studies", "")).toEqual({ page: "studies" });
  expect(routeOf("/studies/comfort", "")).toEqual({ page: "study", studyId: "comfort" });
  expect(routeOf(`/studies/${id}`, "")).toEqual({ page: "study", studyId: id });
  expect(routeOf(`/studies/${id}`, "#preview")).toEqual({ page: "preview", studyId: id });
  expect(routeOf("/studies/nothing", "")).toEqual({ page: "not_found" });
  expect(routeOf("/study", `#${secret}`)).toEqual({ page: "take_part", token: secret });
  expect(routeOf("/study", `#withdraw:${secret}`)).toEqual({ page: "withdraw", key: secret });
  expect(routeOf("/study", "#withdraw:short")).toEqual({ page: "incomplete_link" });
});

test("a comparison names both scans, and whether one lies over the other", () => {
  const [first, second] = ["0123abcd-0000-4000-8000-000000000000", "4567abcd-0000-4000-8000-000000000000"];
  const page = "compare";
  expect(routeOf(comparePath(first, second), "")).toEqual({ page, first, second, over: false });
  expect(routeOf(comparePath(first, second, true), "")).toEqual({ page, first, second, over: true });
  for (const path of [`/compare/${first}`, `/compare/${first}/nothing`, `/compare/${first}/${second}/else`])
    expect(routeOf(path, "")).toEqual({ page: "not_found" });
});
