import type { Texts } from "../shape";

export const legal: Texts["legal"] = {
  nav: "Rechtliche Hinweise",
  pages: { privacy: "Datenschutz", terms: "Nutzungsbedingungen", contact: "Kontakt und Impressum" },
  template:
    "Der Betreiber dieser Installation hat diese Seite noch nicht ausgefüllt. Die markierten Stellen fehlen noch. Wenn Sie der Betreiber sind, lesen Sie „Legal pages“ in docs/operate.md.",
  reminder: (pages) =>
    `Auf diesen Seiten müssen Sie noch Stellen ausfüllen: ${pages}. Wie das geht, steht unter „Legal pages“ in docs/operate.md.`,
  failed: "Diese Seite konnte nicht geladen werden.",
};
