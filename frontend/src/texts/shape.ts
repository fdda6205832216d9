/** What every language has to have: the same keys, the same arguments, a text wherever English has one. */
export type Translation<Part> = Part extends string
  ? string
  : Part extends (...given: infer Given) => infer Said
    ? (...given: Given) => Translation<Said>
    : Part extends number | boolean
      ? Part
      : { readonly [Key in keyof Part]: Translation<Part[Key]> };

/** While texts are added: what is not translated yet may be missing. */
export type Soon<Part> = Part extends string | number | boolean | ((...given: never[]) => unknown) | readonly unknown[] ? Part : { readonly [Key in keyof Part]?: Soon<Part[Key]> };
