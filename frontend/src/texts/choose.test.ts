import { expect, test } from "vitest";
import { choose_language, place_of } from "./choose";

test("the first language of the browser that there is", () => {
  expect(choose_language(null, ["fr-FR", "de-AT", "en"])).toBe("de");
  expect(choose_language(null, ["en-GB", "de"])).toBe("en");
  expect(choose_language(null, ["DE"])).toBe("de");
});

test("English for everybody else, and never a language that merely begins alike", () => {
  expect(choose_language(null, ["fr"])).toBe("en");
  expect(choose_language(null, [])).toBe("en");
  expect(choose_language(null, ["den-CA", "dechoo"])).toBe("en");
});

test("what a person chose goes before the browser, what is no choice does not", () => {
  expect(choose_language("en", ["de"])).toBe("en");
  expect(choose_language("de", ["en"])).toBe("de");
  expect(choose_language("tlh", ["de"])).toBe("de");
  expect(choose_language("constructor", ["en"])).toBe("en");
});

test("dates are written as at the person's place where its language is shown", () => {
  expect(place_of("en", ["de-DE", "en-GB"])).toBe("en-GB");
  expect(place_of("de", ["en-US"])).toBe("de");
});
