import type { Texts } from "../shape";
import { count, fixed } from "./counting";

export const labels: Texts["labels"] = {
  lead: "Diese Strukturen sind in der Aufnahme markiert. Wählen Sie eine aus, um ihr Aussehen zu ändern. Um Strukturen im Inneren zu sehen, blenden Sie alles aus, was nicht markiert ist.",
  coloured: "Die Strukturen farbig zeigen",
  name: "Was ist das?",
  press: "Drücken Sie im Bild auf eine Struktur, um ihren Namen zu sehen.",
  done: "Fertig",
  noAnswer: "Der Server hat nicht geantwortet. Versuchen Sie es noch einmal.",
  nothingThere: "An dieser Stelle ist nichts von der Aufnahme. Wählen Sie eine andere.",
  unmarked: "Hier ist keine Struktur markiert.",
  found: {
    brain: "Gehirn mit umgebendem Hirnwasser",
    bone: "Knochen",
    lungs: "Lunge",
    airways: "Atemwege",
    vessels: "Gefäße mit Kontrastmittel",
  },
  allFound: "Der Server hat diese Strukturen automatisch erkannt. Sie können falsch sein.",
  someFound: (names) => `Der Server hat diese automatisch erkannt, und sie können falsch sein: ${names}.`,
  untitled: (number) => `Struktur ${number}`,
  show: (name) => `${name} zeigen`,
  only: "Nur diese",
  onlyOf: (name) => `Nur ${name} zeigen`,
  rest: "Alles zeigen, was nicht markiert ist",
  colour: "Farbe",
  opacity: "Deckkraft",
  volume: (millilitres) => `${fixed(millilitres, millilitres < 10 ? 2 : millilitres < 100 ? 1 : 0)} ml`,

  title: (title) => `Strukturen von ${title}`,
  explain:
    "Strukturen sind markierte Teile einer Aufnahme, zum Beispiel Organe. Wählen Sie eine Datei, die zu dieser Aufnahme gehört: NIfTI (.nii, .nii.gz), DICOM-Segmentierung (SEG) oder DICOM-Strukturensatz (RTSTRUCT). Öffnen Sie danach die Aufnahme, und wählen Sie links „Strukturen“.",
  privacy:
    "Gesendet werden nur die Strukturen mit ihren Namen und Farben. Name, Datumsangaben und Nummern der Patientin oder des Patienten werden vorher aus der Datei entfernt. Personen, mit denen Sie die Aufnahme teilen, sehen die Strukturen auch. Gäste, Personen mit einem Link und die Galerie erfahren die Namen nicht.",
  choose: "Datei auswählen",
  replace: "Ersetzen",
  remove: "Entfernen",
  none: "Sie haben dieser Aufnahme noch keine Strukturen hinzugefügt.",
  has: (labels, bytes) =>
    `In dieser Aufnahme ${labels === 1 ? "ist" : "sind"} ${count(labels, "Struktur", "Strukturen")} markiert (${bytes}).`,
  onCard: (labels) => count(labels, "Struktur", "Strukturen"),
  refused: {
    labels_other_scan: "Diese Strukturen gehören nicht zu dieser Aufnahme.",
    labels_old_scan:
      "Diese Aufnahme wurde hinzugefügt, bevor es Strukturen gab. Fügen Sie die Aufnahme noch einmal hinzu und danach ihre Strukturen.",
    labels_unsupported: "Diese Art von Datei wird nicht unterstützt.",
    labels_damaged: "Die Datei ist beschädigt oder enthält keine Strukturen.",
    labels_too_large: "Die Datei ist zu groß.",
    over_quota:
      "In Ihrem Speicher ist kein Platz für diese Strukturen. Löschen Sie andere Aufnahmen, und fügen Sie die Strukturen noch einmal hinzu.",
    infected: "Der Virenscanner hat in dieser Datei Schadsoftware gefunden, deshalb wurde sie gelöscht.",
    other: "Der Server konnte diese Datei nicht lesen. Versuchen Sie es noch einmal.",
  },
  phases: {
    reading: "Die Datei wird gelesen …",
    sending: "Die Datei wird hochgeladen …",
    placing: "Die Strukturen werden der Aufnahme zugeordnet …",
  },
  sending: (part) => `Wird hochgeladen … ${Math.floor(100 * part)} %`,
  faults: {
    unknown:
      "Diese Datei enthält keine markierten Strukturen. Wählen Sie eine NIfTI-Datei mit Strukturen, eine DICOM-Segmentierung oder einen Strukturensatz.",
    damaged: "Diese Datei ist beschädigt. Versuchen Sie, sie noch einmal zu kopieren.",
    too_large: "Diese Datei ist zu groß.",
    rejected: "Der Server hat die Datei abgelehnt. Versuchen Sie es noch einmal.",
    over_quota: "In Ihrem Speicher ist kein Platz für diese Strukturen. Löschen Sie zuerst andere Aufnahmen.",
    busy: "Frühere Strukturen dieser Aufnahme werden noch verarbeitet. Versuchen Sie es gleich noch einmal.",
  },
};
