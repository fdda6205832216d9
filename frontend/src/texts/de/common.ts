import type { Texts } from "../shape";
import type { common as english } from "../en/common";

export const common: Pick<Texts, keyof typeof english> = {
  name: "Diaphane",
  tagline: "Sehen Sie Ihre eigene Aufnahme in 3D.",
  skip: "Zum Inhalt springen",
  theme: { toDark: "Zur dunklen Darstellung wechseln", toLight: "Zur hellen Darstellung wechseln" },
  nav: {
    scans: "Aufnahmen",
    add: "Hinzufügen",
    admin: "Verwaltung",
    account: "Ihr Konto",
    signOut: "Abmelden",
    signed_in_as: (email) => `Angemeldet als ${email}`,
  },
  language: "Sprache",
  close: "Schließen",
  cancel: "Abbrechen",
  tryAgain: "Erneut versuchen",
  loading: "Wird geladen …",
  loadingSlow: "Wird noch geladen. Der Server antwortet gerade langsam; es geht nichts verloren.",
  notFound: "Diese Seite gibt es nicht. Prüfen Sie die Adresse oder gehen Sie zur Startseite.",
  incompleteLink:
    "Ein Teil fehlt. Kopieren Sie den ganzen Link bis zum letzten Zeichen, oder bitten Sie noch einmal darum.",
  toStart: "Zur Startseite",
};
