import { expect, test } from "vitest";
import { chooseLanguage, placeOf } from "./choose";

test("uses the first of the browser's languages that is available", () => {
  expect(chooseLanguage(null, ["fr-FR", "de-AT", "en"])).toBe("de");
  expect(chooseLanguage(null, ["en-GB", "de"])).toBe("en");
  expect(chooseLanguage(null, ["DE"])).toBe("de");
});

test("falls back to English, and never to a language that only begins alike", () => {
  expect(chooseLanguage(null, ["fr"])).toBe("en");
  expect(chooseLanguage(null, [])).toBe("en");
  expect(chooseLanguage(null, ["den-CA", "dechoo"])).toBe("en");
});

test("prefers the user's valid choice to the browser's", () => {
  expect(chooseLanguage("en", ["de"])).toBe("en");
  expect(chooseLanguage("de", ["en"])).toBe("de");
  expect(chooseLanguage("tlh", ["de"])).toBe("de");
  expect(chooseLanguage("constructor", ["en"])).toBe("en");
});

test("formats dates for the user's region if its language is shown", () => {
  expect(placeOf("en", ["de-DE", "en-GB"])).toBe("en-GB");
  expect(placeOf("de", ["en-US"])).toBe("de");
});
