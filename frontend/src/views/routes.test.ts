import { expect, test } from "vitest";
import { first_words, route_of } from "./routes";

test("an address without sense is no page, whatever word it begins with", () => {
  expect(route_of("/nothing", "")).toEqual({ page: "not_found" });
  expect(route_of("/constructor", "")).toEqual({ page: "not_found" });
  expect(route_of("/view/../../etc", "")).toEqual({ page: "not_found" });
  expect(route_of("/join", "#short")).toEqual({ page: "not_found" });
});

test("a secret is read from behind the #, an id from the path", () => {
  const secret = "0f".repeat(32);
  const id = "0123abcd-0000-4000-8000-000000000000";
  expect(route_of("/join", `#${secret}`)).toEqual({ page: "join", token: secret });
  expect(route_of("/verify", `#token=${secret}`)).toEqual({ page: "verify", token: secret });
  expect(route_of(`/view/${id}`, "")).toEqual({ page: "view", data_set_id: id });
});

test("parts of the administration are known", () => {
  expect(route_of("/admin", "")).toEqual({ page: "admin", part: "users" });
  expect(route_of("/admin/audit", "")).toEqual({ page: "admin", part: "audit" });
  expect(route_of("/admin/nothing", "")).toEqual({ page: "not_found" });
  expect(route_of("/reset", "#token=abc")).toEqual({ page: "reset", token: "abc" });
});

test("every first word is one word of a path", () => {
  for (const word of first_words) expect(word).toMatch(/^[a-z-]*$/);
});
