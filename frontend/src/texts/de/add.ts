import type { Texts } from "..";
import { count, fixed, number } from "./counting";
import { reasons } from "./reasons";

export const add: Texts["add"] = {
  lead: "Wählen Sie den Ordner oder die CD, die Sie vom Krankenhaus haben. Die Schichten werden von selbst gefunden, wie auch immer die Dateien heißen.",
  privacy: "Name, Daten und Nummern der Person werden aus den Dateien entfernt, bevor sie gesendet werden: Sie verlassen diesen Browser nie. Der Server behält nur das Volumen und löscht die Dateien.",
  privacy_short: "Der Name wird nur hier gezeigt. Er wird entfernt, bevor etwas gesendet wird.",
  drop: "Ordner hierher ziehen",
  dropping: "Loslassen, um hineinzusehen",
  or: "oder",
  choose: "Ordner wählen",
  scanning: "Die Dateien werden angesehen …",
  scanned: (done, total) => `${number.format(done)} von ${count(total, "Datei", "Dateien")}`,
  stop: "Anhalten",
  another: "Anderen Ordner wählen",
  failed: "Der Ordner konnte nicht gelesen werden. Bitte versuchen Sie es noch einmal.",
  found: (n) => (n === 1 ? "Eine Serie kann gezeigt werden" : `${number.format(n)} Serien können gezeigt werden`),
  nothing: "Hier ist keine Aufnahme, die gezeigt werden kann",
  nothing_empty: "Der Ordner ist leer.",
  nothing_no_dicom: (n) => (n === 1 ? "Die eine Datei ist keine DICOM-Datei." : `Keine der ${number.format(n)} Dateien ist eine DICOM-Datei.`) + " Auf CDs vom Krankenhaus liegen sie oft in einem Ordner namens DICOM.",
  nothing_hint: "Das wurde gefunden, und darum kann es nicht gezeigt werden.",
  hidden: (n) => `${count(n, "Serie wird", "Serien werden")} nicht gezeigt. Warum?`,
  others: (n) => `${count(n, "Datei ist", "Dateien sind")} nicht DICOM und ${n === 1 ? "bleibt" : "bleiben"} unberührt.`,
  unreadable: (n) => `${count(n, "Datei konnte", "Dateien konnten")} nicht gelesen werden.`,
  series_untitled: "Serie ohne Namen",
  slices: (n) => count(n, "Schicht", "Schichten"),
  size: (x, y, z) => `${x.toFixed(0)} × ${y.toFixed(0)} × ${z.toFixed(0)} mm`,
  born: (date) => `geboren am ${date}`,
  patient_unknown: "Person ohne Namen",
  thumbnail: "Mittlere Schicht",
  no_thumbnail: "Keine Vorschau: komprimiert",
  title: "Ihr Name für diese Aufnahme",
  title_hint: "Freiwillig. Andere sehen ihn nicht; besser kein Name eines Menschen.",
  title_example: "Kopf, Frühjahr",
  upload: "Hochladen",
  starting: "Es geht los …",
  left_out: (left) =>
    [
      left.doubles > 0 ? `${count(left.doubles, "doppelte Schicht", "doppelte Schichten")} ausgelassen` : "",
      left.scouts > 0 ? `${count(left.scouts, "Übersichtsbild", "Übersichtsbilder")} ausgelassen` : "",
      left.others > 0 ? `${count(left.others, "Schicht", "Schichten")} von anderer Größe ausgelassen` : "",
      left.damaged > 0 ? `${count(left.damaged, "beschädigte Schicht", "beschädigte Schichten")} ausgelassen` : "",
    ].filter((text) => text !== ""),
  go_on: "Hochladen fortsetzen",
  go_on_text: (percent) => `Das Hochladen dieser Aufnahme wurde bei ${percent} % unterbrochen. Was angekommen ist, wird nicht noch einmal gesendet.`,
  sent_elsewhere: "Diese Aufnahme wird gerade in einem anderen Fenster dieses Browsers hochgeladen.",
  storage_full: "Der Server hat gerade keinen Platz mehr. Es wurde nichts gesendet. Bitte versuchen Sie es später noch einmal.",
  repair: (repair) => {
    switch (repair.kind) {
      case "straightened":
        return `schräg aufgenommen, wird um ${fixed(repair.degrees, 1)} Grad aufgerichtet`;
      case "filled_in":
        return `${count(repair.slices, "fehlende Schicht wird", "fehlende Schichten werden")} aus den Nachbarn ergänzt`;
      case "varying":
        return `die Schichten liegen ${fixed(repair.from_mm, 1)} bis ${fixed(repair.to_mm, 1)} mm auseinander, darum können kleine Dinge unscharf aussehen`;
    }
  },
  not_slices: (n) => `${count(n, "Datei ist keine Schicht", "Dateien sind keine Schichten")} (Befunde, Bildschirmfotos, Pläne).`,
  only_reports: "Hier sind nur Befunde oder Bildschirmfotos, keine Schichten einer Aufnahme. Fragen Sie nach den Bildern der Aufnahme im DICOM-Format.",
  over_quota: (needs, free) => `Diese Aufnahme braucht ${needs}, und ${free} Ihres Platzes sind frei. Bitte löschen Sie zuerst eine Aufnahme.`,
  too_large: "Diese Aufnahme ist größer, als hochgeladen werden darf.",
  reasons,
};
