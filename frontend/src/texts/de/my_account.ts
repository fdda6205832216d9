import type { Texts } from "../shape";
import { number } from "./counting";

export const myAccount: Texts["myAccount"] = {
  room: "Ihr Speicherplatz und Ihre Rechenzeit",
  storage: "Speicherplatz",
  storageUsed: (used, all) => `${used} von ${all}`,
  time: "Rechenzeit in diesem Monat",
  timeUsed: (used, all) => `${used} von ${all}`,
  timeHelp: (date) =>
    `Rechenzeit ist die Zeit, in der unsere Server Ihre Bilder berechnen. Fertige Bilder verbrauchen keine. Am ${date} wird sie zurückgesetzt.`,
  timeSpent: (date) => `Ihre Rechenzeit für diesen Monat ist aufgebraucht. Am ${date} wird sie zurückgesetzt.`,
  hours: (ms) => {
    const minutes = ms / 60_000;
    return minutes < 1
      ? `${Math.round(ms / 1000)} s`
      : minutes < 120
        ? `${Math.round(minutes)} min`
        : `${number.format(Math.round(minutes / 6) / 10)} h`;
  },
  address: "Ihre E-Mail-Adresse",
  addressNow: (email) => `Sie melden sich mit ${email} an.`,
  newAddress: "Neue E-Mail-Adresse",
  changeAddress: "E-Mail-Adresse ändern",
  addressSent: (email) =>
    `Wir haben einen Link an ${email} geschickt. Öffnen Sie ihn, um die neue Adresse zu bestätigen. Bis dahin ändert sich nichts.`,
  password: "Ihr Passwort",
  current: "Aktuelles Passwort",
  changePassword: "Passwort ändern",
  passwordChanged: "Ihr Passwort wurde geändert. Alle anderen Browser wurden abgemeldet.",
  browsers: "Wo Sie angemeldet sind",
  browsersHelp:
    "Zu jeder Anmeldung speichern wir nur die Zeit und ungefähr, welcher Browser es war, aber weder Ort noch IP-Adresse.",
  aBrowser: "Unbekannter Browser",
  thisOne: "dieser Browser",
  since: (when) => `seit ${when}`,
  used: (when) => `zuletzt benutzt: ${when}`,
  endOne: "Abmelden",
  endOneOf: (browser) => `${browser} abmelden`,
  endAll: "Überall abmelden",
  data: "Ihre Daten",
  exportHelp:
    "Sie können eine Datei mit allem herunterladen, was wir über Sie gespeichert haben: Ihr Konto, Ihre Aufnahmen als 3D-Bilddaten, Ihre Voreinstellungen und Aufzeichnungen und ein Protokoll darüber, was damit geschehen ist. Nur Sie können die Datei herunterladen. Nach einem Tag löschen wir sie.",
  exportAsk: "Datei erstellen",
  exportQueued: "Die Datei wird erstellt …",
  exportWaiting:
    "Auf dem Server ist gerade kein Platz für die Datei. Sie wird erstellt, sobald wieder Platz ist. Sie müssen nicht auf dieser Seite warten.",
  exportReady: (size) => `Die Datei ist fertig: ${size}.`,
  exportUntil: (when) => `Sie können sie bis ${when} herunterladen.`,
  exportFailed: "Die Datei konnte nicht erstellt werden. Bitte versuchen Sie es noch einmal.",
  exportGet: "Herunterladen",
  exportDelete: "Datei löschen",
  remove: "Konto löschen",
  removeHelp:
    "Mit Ihrem Konto werden auch Ihre Aufnahmen, Bilder, Voreinstellungen und Aufzeichnungen gelöscht, und alle Freigaben enden. Das geschieht sofort und lässt sich nicht rückgängig machen.",
  removeAsk: "Mein Konto löschen …",
  removeTitle: "Konto löschen?",
  removeText:
    "Damit werden Ihr Konto und alle Ihre Aufnahmen endgültig gelöscht. Offene Bilder werden geschlossen, und Links gelten nicht mehr. Das lässt sich nicht rückgängig machen. Geben Sie zur Bestätigung Ihr Passwort ein.",
  removeYes: "Konto löschen",
  removed: "Ihr Konto und alle zugehörigen Daten wurden gelöscht.",
};
