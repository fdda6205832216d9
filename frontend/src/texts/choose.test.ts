import { expect, test } from "vitest";
import { chooseLanguage, placeOf } from "./choose";

test("the first language of the browser that there is", () => {
  expect(chooseLanguage(null, ["fr-FR", "de-AT", "en"])).toBe("de");
  expect(chooseLanguage(null, ["en-GB", "de"])).toBe("en");
  expect(chooseLanguage(null, ["DE"])).toBe("de");
});

test("English for everybody else, and never a language that merely begins alike", () => {
  expect(chooseLanguage(null, ["fr"])).toBe("en");
  expect(chooseLanguage(null, [])).toBe("en");
  expect(chooseLanguage(null, ["den-CA", "dechoo"])).toBe("en");
});

test("a valid choice of the person goes before the browser's", () => {
  expect(chooseLanguage("en", ["de"])).toBe("en");
  expect(chooseLanguage("de", ["en"])).toBe("de");
  expect(chooseLanguage("tlh", ["de"])).toBe("de");
  expect(chooseLanguage("constructor", ["en"])).toBe("en");
});

test("dates are written as at the person's place where its language is shown", () => {
  expect(placeOf("en", ["de-DE", "en-GB"])).toBe("en-GB");
  expect(placeOf("de", ["en-US"])).toBe("de");
});
