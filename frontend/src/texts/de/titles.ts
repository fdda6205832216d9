import type { Texts } from "..";

export const titles: Texts["titles"] = {
  sign_up: "Legen Sie Ihr Konto an",
  sign_in: "Anmelden",
  code: "Ihr Code",
  verify: "Wählen Sie Ihr Passwort",
  check_mail: "Sehen Sie in Ihre E-Mails",
  forgot: "Ein neues Passwort",
  reset: "Wählen Sie ein neues Passwort",
  confirm_email: "Ihre neue Adresse",
  account: "Ihr Konto",
  admin: "Verwaltung",
  scans: "Meine Aufnahmen",
  add: "Neue Aufnahme",
  view: "Ansicht",
  not_found: "Hier ist nichts",
};
