import type { Texts } from "../shape";

export const legal: Texts["legal"] = {
  nav: "Rechtliche Hinweise",
  pages: { privacy: "Datenschutz", terms: "Nutzungsbedingungen", contact: "Kontakt und Impressum" },
  template:
    "Der Betreiber dieser Installation hat diese Seite noch nicht ausgefüllt. Die markierten Angaben fehlen noch. Wenn Sie der Betreiber sind, lesen Sie „Legal pages“ in docs/operate.md.",
  reminder: (pages) =>
    `Diese Seiten enthalten noch Platzhalter, die Sie ausfüllen müssen: ${pages}. Wie das geht, steht unter „Legal pages“ in docs/operate.md.`,
  failed: "Diese Seite konnte nicht geladen werden. Laden Sie sie neu, um es noch einmal zu versuchen.",
};
