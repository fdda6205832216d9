/** The installation's privacy notice, terms and contact, whose texts its operator writes. */
export const legal = {
  nav: "Legal information",
  pages: { privacy: "Privacy notice", terms: "Terms of use", contact: "Contact" },
  template:
    "The operator of this installation hasn’t completed this page yet. The marked details are still missing. If you are the operator, see “Legal pages” in docs/operate.md.",
  reminder: (pages: string) =>
    `These pages still contain placeholders that you must fill in: ${pages}. “Legal pages” in docs/operate.md describes how.`,
  failed: "This page couldn’t be loaded. Reload it to try again.",
} as const;
