import type { Texts } from "../shape";

export const apiTokens: Texts["apiTokens"] = {
  title: "API-Tokens",
  about:
    "Mit einem API-Token kann ein Programm, zum Beispiel ein Python-Skript, Ihr Konto ohne Ihr Passwort nutzen. Ein Token kann niemals Ihr Passwort, Ihre Zwei-Faktor-Authentifizierung, Ihre Tokens oder Ihr Konto ändern. Wenn Sie Ihr Passwort ändern oder sich überall abmelden, werden alle Tokens widerrufen.",
  none: "Sie haben keine API-Tokens.",
  scopes: {
    read: "Aufnahmen auflisten, ansehen und rendern",
    write: "Aufnahmen hochladen, bearbeiten und löschen",
    share: "Aufnahmen mit Personen, über Links und in der Galerie teilen",
    archive: "Aufnahmen aus dem Archiv des Krankenhauses holen und an Diaphane senden",
  },
  until: (day) => `Gültig bis ${day}`,
  used: (when) => `zuletzt benutzt: ${when}`,
  unused: "nie benutzt",
  revoke: "Widerrufen",
  revokeOne: (name) => `${name} widerrufen`,
  full: "Sie haben so viele Tokens, wie ein Konto haben kann. Widerrufen Sie zuerst eines.",
  ask: "Token erstellen …",
  name: "Name",
  nameHint: "Wofür das Token gedacht ist, zum Beispiel „Laptop im Labor“.",
  may: "Das Token darf",
  noScope: "Wählen Sie mindestens ein Recht aus.",
  life: "Gültig für",
  lives: { 7: "7 Tage", 30: "30 Tage", 90: "90 Tage", 365: "1 Jahr" },
  create: "Token erstellen",
  newToken:
    "Ihr neues Token. Kopieren Sie es jetzt, denn es wird nicht noch einmal angezeigt. Jeder, der es hat, kann Ihr Konto nutzen.",
  tokenText: "Neues Token",
  copy: "Kopieren",
  copied: "Kopiert.",
  copyFailed: "Das Token konnte nicht kopiert werden. Markieren Sie es und kopieren Sie es selbst.",
  kept: "Ich habe es gespeichert",
};
