import type { Texts } from "..";
import type { common as english } from "../en/common";

export const common: Pick<Texts, keyof typeof english> = {
  name: "Diaphane",
  tagline: "Sehen Sie Ihre Aufnahme, wie sie ist.",
  skip: "Zum Inhalt springen",
  theme: { to_dark: "Dunkle Ansicht", to_light: "Helle Ansicht" },
  nav: { scans: "Aufnahmen", add: "Hinzufügen", admin: "Verwaltung", account: "Ihr Konto", sign_out: "Abmelden", signed_in_as: (email) => `Angemeldet als ${email}` },
  language: "Sprache",
  close: "Schließen",
  cancel: "Abbrechen",
  try_again: "Noch einmal versuchen",
  loading: "Wird geladen …",
  not_found: "Diese Seite gibt es nicht.",
  to_start: "Zum Anfang",
};
