import type { Texts } from "../shape";
import { number } from "./counting";

const signed = (value: number): string => number.format(value).replace("-", "−");

export const scanFile: Texts["scanFile"] = {
  title: "Aufnahme für andere Programme exportieren",
  lead: "Erstellen Sie eine Datei, die andere Programme öffnen können: die ganze Aufnahme für Forschung und Behandlungsplanung oder ein 3D-Modell eines Teils, zum Beispiel um einen Knochen zu drucken.",
  warning:
    "Anhand der Datei lässt sich die abgebildete Person womöglich erkennen: Ein Modell der Haut zeigt das Gesicht, und auch in der ganzen Aufnahme kann es enthalten sein. Geben Sie die Datei nur Menschen, denen Sie vertrauen.",
  format: "Format",
  formats: {
    nifti: "Ganze Aufnahme (NIfTI)",
    stl: "3D-Modell zum Drucken (STL)",
    glb: "3D-Modell mit Farbe (glTF)",
  },
  formatHints: {
    nifti: "Enthält alle Werte der Aufnahme, wie sie hier gespeichert sind, und ihre Lage im Körper.",
    stl: "In Millimetern und ohne Löcher. Die Farbe gehört nicht zu diesem Format.",
    glb: "In Metern und ohne Löcher, für 3D-Programme und Webseiten.",
  },
  part: "Teil der Aufnahme",
  byValue: "Alles oberhalb eines Werts",
  above: "Niedrigster Wert des Teils",
  aboveHounsfield: "Niedrigster Wert des Teils, in HE",
  aboveHintCt: "300 HE zeigt die Knochen, −300 HE die Haut.",
  aboveHint: (minimum, maximum) =>
    `Die Werte dieser Aufnahme liegen zwischen ${signed(minimum)} und ${signed(maximum)}. Helleres Gewebe hat höhere Werte.`,
  wrongAbove: (minimum, maximum) => `Geben Sie eine ganze Zahl zwischen ${signed(minimum)} und ${signed(maximum)} ein.`,
  create: "Datei erstellen",
  queued: "Die Datei wird erstellt. Sie können dieses Fenster inzwischen schließen.",
  waiting:
    "Der Server kann die Datei gerade nicht erstellen. Er holt es nach, sobald es geht. Sie können dieses Fenster inzwischen schließen.",
  stop: "Abbrechen",
  ready: (format, size) => `${format}: Die Datei ist fertig, ${size}.`,
  get: "Herunterladen",
  another: "Datei löschen",
  busy: "Eine andere Datei von Ihnen wird noch erstellt. Warten Sie, bis sie fertig ist, und versuchen Sie es dann noch einmal.",
  failed: "Die Datei konnte nicht erstellt werden. Bitte versuchen Sie es noch einmal.",
  failures: {
    nothing_inside:
      "Nichts in der Aufnahme gehört zu dieser Struktur oder hat einen so hohen Wert. Wählen Sie einen anderen Teil.",
    too_large: "Dieser Teil der Aufnahme ist zu groß für den Export. Wählen Sie einen kleineren Teil.",
    too_slow: "Das Erstellen der Datei hat zu lange gedauert. Mit einem kleineren Teil kann es gelingen.",
    no_memory:
      "Dem Server hat jedes Mal der Speicher gefehlt, um die Datei zu erstellen. Wählen Sie einen kleineren Teil.",
  },
};
