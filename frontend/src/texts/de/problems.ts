import type { Texts } from "../shape";

export const problems: Texts["problems"] = {
  offline: "Diaphane ist nicht erreichbar. Prüfen Sie Ihre Verbindung und versuchen Sie es noch einmal.",
  unreachable: "Diaphane ist nicht erreichbar. Wir versuchen es weiter …",
  busy: "Diaphane ist gerade ausgelastet. Versuchen Sie es gleich noch einmal.",
  outcomeUnknown:
    "Die Verbindung ist beim Speichern abgebrochen. Laden Sie die Seite neu, um zu sehen, ob Ihre Änderung gespeichert wurde.",
  internal: "Bei uns ist etwas schiefgegangen. Versuchen Sie es gleich noch einmal.",
  wrongCredentials:
    "Die E-Mail-Adresse oder das Passwort ist falsch. Prüfen Sie beides und versuchen Sie es noch einmal.",
  disabled:
    "Dieses Konto wurde von der Administration gesperrt. Wenden Sie sich an die Stelle, die diesen Diaphane-Server betreibt.",
  tooMany: "Zu viele Versuche. Warten Sie eine Weile und versuchen Sie es dann noch einmal.",
  linkExpired: "Dieser Link ist abgelaufen oder wurde schon benutzt. Fordern Sie einen neuen an.",
};
