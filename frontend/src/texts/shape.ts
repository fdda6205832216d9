import type { en } from "./en/en";

/** The type of a translation: the same keys and arguments, and a text wherever English has one. */
export type Translation<Part> = Part extends string
  ? string
  : Part extends (...given: infer Given) => infer Said
    ? (...given: Given) => Translation<Said>
    : Part extends number | boolean
      ? Part
      : { readonly [Key in keyof Part]: Translation<Part[Key]> };

/** All texts of one language. */
export type Texts = Translation<typeof en>;
