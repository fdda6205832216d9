import type { Texts } from "..";

export const problems: Texts["problems"] = {
  offline: "Diaphane ist nicht erreichbar. Prüfen Sie Ihre Verbindung und versuchen Sie es noch einmal.",
  unreachable: "Diaphane ist nicht erreichbar. Es wird weiter versucht …",
  busy: "Diaphane ist gerade ausgelastet. Versuchen Sie es gleich noch einmal.",
  outcome_unknown: "Die Verbindung ist beim Speichern abgebrochen. Laden Sie die Seite neu, um zu sehen, ob die Änderung gespeichert wurde.",
  internal: "Bei uns ist etwas schiefgegangen. Versuchen Sie es gleich noch einmal.",
  wrong_credentials: "Diese Adresse und dieses Passwort gehören nicht zusammen.",
  disabled: "Dieses Konto wurde von der Verwaltung abgeschaltet. Schreiben Sie an die Stelle, die dieses Diaphane betreibt.",
  too_many: "Zu viele Versuche. Warten Sie ein wenig und versuchen Sie es noch einmal.",
  link_expired: "Dieser Link wurde schon benutzt oder ist zu alt. Fordern Sie einen neuen an.",
};
