import type { Texts } from "../shape";

export const problems: Texts["problems"] = {
  unreachable: "Diaphane ist nicht erreichbar. Wir versuchen es weiter …",
  internal: "Bei uns ist etwas schiefgegangen. Versuchen Sie es gleich noch einmal.",
  notTaken: "Der Server hat diese Änderung nicht angenommen. Laden Sie die Seite neu und versuchen Sie es noch einmal.",
  always: {
    offline: "Diaphane ist nicht erreichbar. Prüfen Sie Ihre Verbindung und versuchen Sie es noch einmal.",
    "wrong-credentials":
      "Die E-Mail-Adresse oder das Passwort ist falsch. Prüfen Sie beides und versuchen Sie es noch einmal.",
    "code-needed":
      "Die Zwei-Faktor-Authentifizierung wurde in einem anderen Fenster eingeschaltet. Laden Sie die Seite neu und geben Sie dann auch einen Code ein.",
    disabled:
      "Dieses Konto wurde von der Administration gesperrt. Wenden Sie sich an die Administration dieses Diaphane-Servers.",
    "link-expired": "Dieser Link ist abgelaufen oder wurde schon benutzt. Fordern Sie einen neuen an.",
    busy: "Diaphane ist gerade ausgelastet. Versuchen Sie es gleich noch einmal.",
    unavailable: "Diaphane ist gerade ausgelastet. Versuchen Sie es gleich noch einmal.",
    "outcome-unknown":
      "Die Verbindung ist beim Speichern abgebrochen. Laden Sie die Seite neu, um zu sehen, ob Ihre Änderung gespeichert wurde.",
    internal: "Bei uns ist etwas schiefgegangen. Versuchen Sie es gleich noch einmal.",
  },
  fields: {
    email: "Geben Sie eine gültige E-Mail-Adresse ein.",
    password: "Prüfen Sie das Passwort.",
    current: "Das Passwort ist falsch.",
    code: "Dieser Code ist falsch oder wurde schon benutzt. Warten Sie auf den nächsten.",
  },
  kinds: {
    invalid: "Bitte prüfen Sie Ihre Eingabe.",
    unauthenticated: "Sie sind abgemeldet. Melden Sie sich wieder an.",
    "wrong-code": "Dieser Code ist falsch oder wurde schon benutzt. Warten Sie auf den nächsten.",
    forbidden: "Dazu haben Sie keine Berechtigung.",
    "consent-needed": "Die Datenschutzerklärung hat sich geändert. Laden Sie die Seite neu und lesen Sie sie.",
    "second-factor-required": "Richten Sie zuerst die Zwei-Faktor-Authentifizierung ein.",
    "not-found": "Das gibt es nicht mehr, oder Sie haben keinen Zugriff darauf.",
    conflict: "Das ist gerade nicht möglich. Laden Sie die Seite neu und versuchen Sie es noch einmal.",
    "not-ready": "Diese Aufnahme wird noch vorbereitet. Versuchen Sie es gleich noch einmal.",
    "not-aligned": "Diese Aufnahmen haben kein gemeinsames Bezugssystem. Richten Sie sie zuerst aus.",
    "not-anonymised": "Schneiden Sie zuerst alles weg, woran man die Person erkennen könnte.",
    precondition:
      "Das wurde in einem anderen Fenster geändert. Laden Sie die Seite neu und versuchen Sie es noch einmal.",
    "over-quota": "Sie haben nicht genug Speicherplatz frei. Löschen Sie zuerst eine Aufnahme.",
    "too-many-data-sets": "Ihr Konto enthält schon so viele Aufnahmen, wie möglich sind. Löschen Sie zuerst eine.",
    "render-time-spent": "Ihre Rechenzeit für diesen Monat ist aufgebraucht.",
    "upload-too-large": "Diese Aufnahme ist für den Server zu groß.",
    "body-too-large": "Das ist für den Server zu groß.",
    "storage-full": "Der Server hat keinen Speicherplatz mehr. Versuchen Sie es später noch einmal.",
    "too-many": "Zu viele Versuche. Warten Sie eine Weile und versuchen Sie es dann noch einmal.",
    "too-many-attempts": "Zu viele Versuche. Warten Sie eine Weile und versuchen Sie es dann noch einmal.",
    "no-worker": "Zurzeit ist kein Renderserver frei. Versuchen Sie es gleich noch einmal.",
    "archive-unreachable":
      "Das Archiv antwortet nicht. Versuchen Sie es später noch einmal, oder fragen Sie Ihre Administration.",
    "archive-refused":
      "Das Archiv lässt Diaphane nicht zu. Bitten Sie Ihre Administration, die Zugangsdaten zu prüfen.",
    "archive-faulty": "Das Archiv hat etwas Ungültiges geschickt. Fragen Sie Ihre Administration.",
  },
};
