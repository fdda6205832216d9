import { expect, test } from "vitest";
import { firstWords, routeOf } from "./routes";

test("an unknown path is not a page, whatever it begins with", () => {
  expect(routeOf("/nothing", "")).toEqual({ page: "not_found" });
  expect(routeOf("/constructor", "")).toEqual({ page: "not_found" });
  expect(routeOf("/view/../../etc", "")).toEqual({ page: "not_found" });
  expect(routeOf("/join", "#short")).toEqual({ page: "not_found" });
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
