import type { Texts } from "../shape";

export const consent: Texts["consent"] = {
  title: "Wir brauchen Ihre Einwilligung",
  lead: "Aufnahmen sind Gesundheitsdaten. Wir dürfen sie nur verarbeiten, wenn Sie einwilligen. Unsere Datenschutzerklärung ist neu oder hat sich geändert, seit Sie zuletzt eingewilligt haben. Bitte lesen Sie sie, bevor Sie weitermachen.",
  agree:
    "Ich willige ein, dass dieser Dienst meine Aufnahmen, also Gesundheitsdaten, so verarbeitet, wie es in der Datenschutzerklärung steht.",
  notice: "Datenschutzerklärung lesen (öffnet einen neuen Tab)",
  missing: "Setzen Sie hier ein Häkchen, um fortzufahren.",
  go: "Weiter",
  otherwise:
    "Wenn Sie nicht einwilligen, können Sie sich abmelden oder auf der Seite „Ihr Konto“ Ihre Daten herunterladen oder löschen.",
};
