import { expect, it, vi } from "vitest";
import { ApiProblem } from "../api/client";
import type { Me } from "../api/types";
import { AppState } from "./state";

const me = { consent: { version: "2", given_at: null } } as unknown as Me;

it("asks for consent again when the privacy notice has changed", async () => {
  vi.stubGlobal("addEventListener", vi.fn());
  const app = new AppState();
  app.me.value = { ...me, consent: { version: "1", given_at: "2026-01-01T00:00:00Z" } };
  const asked = vi.spyOn(app.api, "me").mockResolvedValue(me);
  app.explain(new ApiProblem(403, "forbidden", ""));
  expect(asked).not.toHaveBeenCalled();
  app.explain(new ApiProblem(403, "consent-needed", ""));
  await vi.waitFor(() => {
    expect(app.me.value).toBe(me);
  });
});
