import type { Texts } from "../shape";
import { count, fixed, number } from "./counting";
import { reasons } from "./reasons";

const mostMs = 1000;
const secondsText = (ms: number): string =>
  ms < mostMs ? `${number.format(Math.round(ms))} ms` : `${number.format(Math.round(ms / 100) / 10)} s`;

export const add: Texts["add"] = {
  lead: "Wählen Sie den Ordner, die CD oder die ZIP-Datei, die Sie vom Krankenhaus bekommen haben. Diaphane findet die Aufnahmen darin, egal wie die Dateien heißen.",
  privacy:
    "Name, Datumsangaben und Kennnummern der untersuchten Person werden aus den Dateien entfernt, bevor etwas diesen Browser verlässt. Wir behalten nur die 3D-Bilddaten und löschen die hochgeladenen Dateien.",
  privacyShort:
    "Den Namen der untersuchten Person sehen nur Sie, hier in diesem Browser. Er wird entfernt, bevor etwas hochgeladen wird.",
  drop: "Ziehen Sie einen Ordner oder eine ZIP-Datei hierher",
  dropping: "Loslassen, um die Dateien zu lesen",
  formats: "DICOM-Ordner, ZIP- und TAR-Archive sowie Dateien in NIfTI, NRRD oder MetaImage",
  or: "oder",
  choose: "Ordner wählen",
  chooseFiles: "Dateien wählen",
  scanning: "Die Dateien werden gelesen …",
  scanned: (done, total) => `${number.format(done)} von ${count(total, "Datei", "Dateien")}`,
  stop: "Anhalten",
  another: "Andere Dateien wählen",
  failed: "Die Dateien konnten nicht gelesen werden. Bitte versuchen Sie es noch einmal.",
  found: (n) =>
    n === 1 ? "1 Bildserie kann angezeigt werden" : `${number.format(n)} Bildserien können angezeigt werden`,
  nothing: "Keine Aufnahme gefunden, die angezeigt werden kann",
  nothingEmpty: "Dieser Ordner ist leer. Wählen Sie einen anderen.",
  nothingNoDicom: (n) =>
    (n === 1
      ? "Diese Datei ist keine DICOM-Datei."
      : `Keine dieser ${number.format(n)} Dateien ist eine DICOM-Datei.`) +
    " Auf CDs vom Krankenhaus liegen die Aufnahmen oft in einem Ordner namens DICOM.",
  nothingHint: "Wir haben Bildserien gefunden, aber keine davon kann angezeigt werden. Die Gründe stehen unten.",
  hidden: (n) =>
    n === 1
      ? "1 Bildserie kann nicht angezeigt werden. Warum?"
      : `${number.format(n)} Bildserien können nicht angezeigt werden. Warum?`,
  others: (n) =>
    n === 1
      ? "1 Datei ist keine DICOM-Datei und wurde nicht berücksichtigt."
      : `${number.format(n)} Dateien sind keine DICOM-Dateien und wurden nicht berücksichtigt.`,
  archives: {
    encrypted: (name) =>
      `„${name}“ ist mit einem Passwort geschützt. Entpacken Sie die Datei zuerst mit dem Passwort und wählen Sie dann den entpackten Ordner.`,
    damaged: (name) =>
      `„${name}“ ist beschädigt oder unvollständig. Darum konnten nicht alle Dateien darin gelesen werden. Kopieren Sie die Datei noch einmal, oder laden Sie sie erneut herunter.`,
    nested: (name) =>
      `„${name}“ enthält zu tief verschachtelte Archive. Entpacken Sie die Datei zuerst und wählen Sie dann den entpackten Ordner.`,
    large: (name) =>
      `„${name}“ enthält mehr, als diese Seite entpacken kann. Entpacken Sie die Datei zuerst und wählen Sie dann den Ordner mit Ihrer Aufnahme.`,
    format: (name) =>
      `„${name}“ ist so gepackt, dass Browser es nicht lesen können. Entpacken Sie die Datei zuerst und wählen Sie dann den entpackten Ordner.`,
  },
  damagedInArchive:
    "Eine Datei dieser Aufnahme ist in ihrem Archiv beschädigt. Darum wurde nichts hochgeladen. Kopieren Sie das Archiv oder laden Sie es noch einmal herunter.",
  unreadable: (n) => `${count(n, "Datei konnte", "Dateien konnten")} nicht gelesen werden.`,
  seriesUntitled: "Serie ohne Namen",
  slices: (n) => count(n, "Schicht", "Schichten"),
  size: (x, y, z) => `${x.toFixed(0)} × ${y.toFixed(0)} × ${z.toFixed(0)} mm`,
  born: (date) => `geboren am ${date}`,
  patientUnknown: "Die Dateien enthalten keinen Namen",
  thumbnail: "Mittlere Schicht",
  noThumbnail: "Keine Vorschau, weil die Bilder komprimiert sind",
  title: "Ihr Name für diese Aufnahme",
  titleProposed: "Ein Vorschlag aus der Aufnahme, den Sie beliebig ändern können.",
  titleHint:
    "Verwenden Sie keinen Personennamen: Zuerst sehen nur Sie den Namen der Aufnahme, später auch alle, mit denen Sie sie teilen.",
  titleExample: "Kopf, Frühjahr",
  best: "Am besten für ein 3D-Bild",
  bestWhy: {
    thinnest: (mm) => `Ihre Schichten sind die dünnsten (${fixed(mm, 1)} mm), darum wird das Bild am glattesten.`,
    largest: (mm) => `Sie zeigt am meisten vom Körper (${mm} mm).`,
  },
  several: "Laden Sie so viele davon hoch, wie Sie möchten. Diese Liste bleibt geöffnet.",
  begun: "Der Upload hat begonnen. Sie finden ihn unter „Meine Aufnahmen“.",
  upload: "Hochladen",
  uploadAll: (n) => `Alle ${n} hochladen`,
  starting: "Wird gestartet …",
  phases: ({ kind, count: n, range: [from, to] }) => {
    const span = `${number.format(from)} bis ${number.format(to)}`;
    switch (kind) {
      case "index":
        return count(n, "Phase", "Phasen");
      case "time":
        return `${count(n, "Phase", "Phasen")} in ${secondsText(to)}`;
      case "cycle":
        return `${count(n, "Phase", "Phasen")} (${span} % eines Herzschlags)`;
      case "echo":
        return `${count(n, "Echo", "Echos")} (${span} ms)`;
      case "b_value":
        return `${count(n, "Diffusionsbild", "Diffusionsbilder")} (b = ${span} s/mm²)`;
    }
  },
  phasesToUpload: "Welche Phasen",
  allPhases: (n) => `Alle ${number.format(n)}`,
  everyPhase: (every, n) =>
    `Jede ${["", "", "zweite", "dritte", "vierte", "fünfte"][every] ?? `${every}.`} (${number.format(n)})`,
  onePhase: "Nur eine",
  phaseNumber: "Phase",
  phaseOf: (i, n) => `${number.format(i)} von ${number.format(n)}`,
  leftOut: (left) =>
    [
      left.doubles > 0 ? `${count(left.doubles, "doppelte Schicht", "doppelte Schichten")} übersprungen` : "",
      left.scouts > 0 ? `${count(left.scouts, "Übersichtsbild", "Übersichtsbilder")} übersprungen` : "",
      left.others > 0 ? `${count(left.others, "Schicht", "Schichten")} anderer Größe übersprungen` : "",
      left.damaged > 0 ? `${count(left.damaged, "beschädigte Schicht", "beschädigte Schichten")} übersprungen` : "",
    ].filter((text) => text !== ""),
  resume: "Upload fortsetzen",
  resumeText: (percent) =>
    `Der Upload dieser Aufnahme wurde bei ${percent} % unterbrochen. Er wird dort fortgesetzt, wo er aufgehört hat.`,
  sentElsewhere: "Diese Aufnahme wird bereits in einem anderen Fenster dieses Browsers hochgeladen.",
  storageFull:
    "Der Server hat keinen Speicherplatz mehr, deshalb wurde nichts hochgeladen. Bitte versuchen Sie es später noch einmal.",
  repair: (repair) => {
    switch (repair.kind) {
      case "straightened":
        return `schräg aufgenommen, die Neigung von ${fixed(repair.degrees, 1)}° wird korrigiert`;
      case "filled_in":
        return `${count(repair.slices, "fehlende Schicht wird", "fehlende Schichten werden")} aus den Nachbarschichten ergänzt`;
      case "varying":
        return `die Schichten liegen ${fixed(repair.fromMm, 1)} bis ${fixed(repair.toMm, 1)} mm auseinander, darum können kleine Einzelheiten unscharf wirken`;
      case "incomplete_phases":
        return `${count(repair.phases, "unvollständige Phase wird", "unvollständige Phasen werden")} ausgelassen`;
      case "uncommon":
        return `${count(repair.slices, "Schicht, die nicht jede Phase hat, wird", "Schichten, die nicht jede Phase hat, werden")} ausgelassen`;
      case "fewer_phases":
        return `nur ${number.format(repair.kept)} von ${number.format(repair.of)} Phasen werden hochgeladen, weil alle zusammen zu groß wären`;
      case "unknown_directions":
        return "die Datei sagt nicht, wo links und rechts ist, darum kann das Bild spiegelverkehrt sein";
    }
  },
  notSlices: (n) =>
    `${count(n, "Datei ist kein Schichtbild", "Dateien sind keine Schichtbilder")} (sondern zum Beispiel Befunde, Bildschirmfotos oder Bestrahlungspläne).`,
  onlyReports:
    "Dieser Ordner enthält nur Befunde oder Bildschirmfotos, aber keine Schichtbilder. Bitten Sie das Krankenhaus um die Bilder der Aufnahme im DICOM-Format.",
  overQuota: (needs, free) =>
    `Diese Aufnahme braucht ${needs} Speicherplatz, aber Sie haben nur noch ${free} frei. Löschen Sie zuerst eine andere Aufnahme.`,
  tooLarge: "Diese Aufnahme ist für den Server zu groß.",
  reasons,
};
