import { expect, it } from "vitest";
import { loadTexts } from "../texts";
import "../texts/testing";
import { detailsText } from "./audit_details";

it("gives the details of an entry in the language of the page", async () => {
  await loadTexts("de");
  const text = (action: string, details: Record<string, number | string>) => detailsText({ action, details });
  expect(text("accounts.looked-at", { items: 3 })).toBe("Einträge: 3");
  expect(text("account.storage-quota-changed", { to: 2e9, from: 1e9 })).toBe("von: 1,0 GB, auf: 2,0 GB");
  expect(text("account.render-quota-changed", { from: 7_200_000, to: 36_000_000 })).toBe("von: 2 h, auf: 10 h");
  expect(text("account.render-quota-changed", { to: 9_000_000 })).toBe("auf: 2,5 h");
  expect(text("data-set.looked-at", { by: "live-link", link: "0d1f" })).toBe("über: gemeinsame Ansicht, Link: 0d1f");
  expect(text("data-set.shared", { may: "save", permission: "0d1f" })).toBe(
    "Recht: ansehen und Voreinstellungen speichern, Freigabe: 0d1f",
  );
  expect(text("data-set.link-made", { link: "8370e8d0-5550-4350-8819-ff84a1b2c3d4" })).toBe("Link: 8370e8d0");
  expect(text("data-set.published", { slices: 1 })).toBe("Schichten: ja");
  expect(text("account.token-created", { scopes: "read.share", token: "8370e8d0-5550-4350-8819-ff84a1b2c3d4" })).toBe(
    "Rechte: ansehen und rendern; teilen, Token: 8370e8d0",
  );
  expect(text("later", { new: "word" })).toBe("new: word");
});
