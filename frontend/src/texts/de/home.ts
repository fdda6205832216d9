import type { Texts } from "../shape";

export const home: Texts["home"] = {
  title: "Sehen Sie Ihre eigene Aufnahme in 3D",
  what: "Diaphane macht aus dem CT oder MRT auf der CD Ihres Krankenhauses ein 3D-Bild, das Sie hier im Browser drehen und von allen Seiten betrachten können.",
  privacy:
    "Der Name der untersuchten Person wird entfernt, bevor etwas hochgeladen wird, und nur Sie sehen Ihre Aufnahmen, solange Sie sie nicht teilen.",
  notMedical:
    "Diaphane ist kein Medizinprodukt und stellt keine Diagnose. Sprechen Sie bitte mit Ihrer Ärztin oder Ihrem Arzt über das, was Sie sehen.",
  sample: "Beispielaufnahme ansehen",
  others: "Weitere Beispiele",
  open: (title) => `Das Beispiel „${title}“ ansehen`,
};
