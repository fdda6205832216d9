import { expect, test } from "vitest";
import { de } from "./de";
import { en } from "./en/en";

// A phone of 390 pixels shows six looks in tiles of 54 pixels, and a letter is 6 wide.
const mostLetters = 9;

test.each(Object.entries({ de, en }))(
  "the parts of a look's name fit into its tile on a phone (%s)",
  (_language, { viewer }) => {
    const names = [...Object.values(viewer.lookOfCt), ...Object.values(viewer.lookOfOther)];
    for (const name of names)
      for (const part of name.split(/[\s\u00AD-]/)) expect(part.length, name).toBeLessThanOrEqual(mostLetters);
  },
);
