import type { Texts } from "../shape";

export const titles: Texts["titles"] = {
  signUp: "Konto erstellen",
  signIn: "Bei Diaphane anmelden",
  code: "Code eingeben",
  verify: "Passwort wählen",
  checkMail: "Prüfen Sie Ihr Postfach",
  forgot: "Passwort zurücksetzen",
  reset: "Neues Passwort wählen",
  resetDone: "Passwort geändert",
  confirmEmail: "Ihre neue E-Mail-Adresse",
  account: "Ihr Konto",
  admin: "Verwaltung",
  scans: "Meine Aufnahmen",
  add: "Aufnahme hinzufügen",
  view: "Ansicht",
  notFound: "Seite nicht gefunden",
  incompleteLink: "Dieser Link ist unvollständig",
};
