import type { Texts } from "../shape";
import type { Correction } from "../../scan/corrections";
import { count, fixed, number } from "./counting";

const corrected: Record<Exclude<Correction, "directions">, string> = {
  tilt: "sie war schräg aufgenommen",
  spacing: "ihre Schichten hatten ungleiche Abstände",
  missing: "einige Schichten fehlten",
  duplicates: "sie enthielt doppelte Bilder",
  overview: "sie enthielt Übersichtsbilder",
  size: "einige Schichten hatten eine andere Größe",
  damaged: "einige Dateien waren beschädigt",
  brightness: "die Helligkeit ihrer Schichten war nicht einheitlich",
  phases: "einige Phasen waren unvollständig oder zu viele",
  negative: "sie war als Negativ gespeichert",
  scaled: "ihre Werte lagen außerhalb des gespeicherten Bereichs",
};

const list = new Intl.ListFormat("de");

export const scans: Texts["scans"] = {
  leadEmpty:
    "Fügen Sie eine Aufnahme aus dem Ordner, der Datei oder von der CD hinzu, die Sie von Ihrem Krankenhaus haben.",
  empty: "Noch keine Aufnahmen",
  add: "Aufnahme hinzufügen",
  list: "Ihre Aufnahmen",
  order: "Sortieren nach",
  orders: { added: "Zuletzt hochgeladen", date: "Datum im Titel", title: "Titel", size: "Größe" },
  examples: "Beispiele",
  used: (used, all) => `${used} von ${all} belegt`,
  untitledOn: (date) => `Aufnahme ohne Namen, ${date}`,
  addedOn: (date) => `hinzugefügt am ${date}`,
  rename: (title) => `${title} umbenennen`,
  renameTitle: "Aufnahme umbenennen",
  renameSave: "Speichern",
  sampleTitles: { Cranium: "Schädel", Head: "Kopf", "Brain of a macaque": "Gehirn eines Makaken" },
  sampleTitle: "Beispielaufnahme",
  sample: "Beispiel",
  shared: "Öffentlich",
  open: (title) => `${title} öffnen`,
  remove: (title) => `${title} löschen`,
  removeTitle: "Diese Aufnahme löschen?",
  removeText: (title) =>
    `„${title}“ und alles, was daraus entstanden ist, wird endgültig gelöscht. Ihre eigene CD bleibt davon unberührt.`,
  removeYes: "Löschen",
  upload: {
    sending: (percent, left) => (left ? `${percent} %, ${left}` : `${percent} %`),
    waiting: "Wartet, bis andere Aufnahmen hochgeladen sind.",
    paused: (percent) => `Angehalten bei ${percent} %.`,
    elsewhere: (percent) => `${percent} %, in einem anderen Fenster.`,
    stalled: {
      connection: "Die Verbindung wurde unterbrochen. Der Upload wird von selbst fortgesetzt.",
      storage_full:
        "Der Server hat keinen Speicherplatz mehr. Was schon hochgeladen ist, bleibt erhalten, und der Upload wird jede Minute erneut versucht.",
    },
    refused: {
      expired:
        "Der Upload war zu lange inaktiv und ist abgelaufen. Löschen Sie ihn und laden Sie die Aufnahme noch einmal hoch.",
      gone: "Dieser Upload wurde gelöscht, hier oder auf einem anderen Gerät.",
      too_large: "Diese Aufnahme ist für den Server zu groß.",
      signed_out:
        "Sie wurden abgemeldet. Melden Sie sich an und wählen Sie denselben Ordner noch einmal. Der Upload wird dann dort fortgesetzt, wo er aufgehört hat.",
      other: "Der Server hat den Upload abgelehnt. Löschen Sie ihn und versuchen Sie es noch einmal.",
    },
    pause: "Anhalten",
    resume: "Fortsetzen",
    pauseOf: (title) => `Upload von ${title} anhalten`,
    resumeOf: (title) => `Upload von ${title} fortsetzen`,
    left: (seconds) =>
      seconds < 50
        ? "noch weniger als eine Minute"
        : seconds < 3300
          ? `noch etwa ${count(Math.round(seconds / 60), "Minute", "Minuten")}`
          : `noch etwa ${count(Math.round(seconds / 3600), "Stunde", "Stunden")}`,
    all: (uploads, percent) => `${count(uploads, "Aufnahme", "Aufnahmen")}, ${percent} %`,
  },
  interrupted: (percent) => `Unterbrochen bei ${percent} %`,
  interruptedHint:
    "Wählen Sie denselben Ordner noch einmal, um den Upload dort fortzusetzen, wo er aufgehört hat. Zum Schutz Ihrer Dateien kann der Browser den Ordner nicht von selbst öffnen.",
  resumeInterrupted: "Fortsetzen",
  cancelUpload: (title) => `Upload von ${title} abbrechen`,
  cancelTitle: "Upload abbrechen?",
  cancelText: (title) =>
    `Was von „${title}“ schon hochgeladen ist, wird sofort gelöscht. Ihre eigene CD bleibt davon unberührt.`,
  cancelYes: "Upload abbrechen",
  cancelNo: "Weiter hochladen",
  serverAway:
    "Der Diaphane-Server ist gerade nicht erreichbar. Ihre Aufnahmen sind sicher, und diese Seite versucht es weiter.",
  states: {
    uploading: "Wird hochgeladen",
    queued: "Wartet",
    building: "Wird vorbereitet",
    ready: "Bereit",
    refused: "Kann nicht angezeigt werden",
    expired: "Upload abgelaufen",
  },
  waitingFor: {
    room: "Auf dem Server ist gerade kein Platz für diese Aufnahme. Ihre Aufnahme ist sicher, und die Verarbeitung geht von selbst weiter, sobald wieder Platz ist.",
    memory:
      "Der Server hat gerade nicht genug Arbeitsspeicher für diese Aufnahme. Ihre Aufnahme ist sicher, und die Verarbeitung geht von selbst weiter.",
    service:
      "Ein Teil des Servers ist gerade nicht erreichbar. Ihre Aufnahme ist sicher, und die Verarbeitung geht von selbst weiter.",
    interruption:
      "Die Verarbeitung wurde mehrmals unterbrochen. Ihre Aufnahme ist sicher, und die Verarbeitung beginnt nach einer Pause von selbst noch einmal.",
  },
  expiredHint:
    "Der Upload wurde nicht rechtzeitig fertig. Löschen Sie ihn und laden Sie die Aufnahme noch einmal hoch.",
  repaired: (what) => {
    const named = what.flatMap((one) => (one === "directions" ? [] : corrected[one]));
    const unsure = "Die Datei sagt nicht, wo links und rechts ist, darum kann das Bild spiegelverkehrt sein.";
    if (named.length > 0)
      return `Wir haben diese Aufnahme korrigiert, denn ${list.format(named)}.${what.includes("directions") ? ` ${unsure}` : ""}`;
    return what.includes("directions") ? unsure : "Wir haben diese Aufnahme korrigiert.";
  },
  phases: (n) => count(n, "Phase", "Phasen"),
  repairDetails: "Einzelheiten",
  repairNote: (note) => {
    switch (note.kind) {
      case "tilt":
        return `Die Neigung des Geräts um ${fixed(note.degrees, 1)}° wurde ausgeglichen.`;
      case "spacing":
        return `Die Schichten lagen ${fixed(note.fromMm, 2)} bis ${fixed(note.toMm, 2)} mm auseinander und wurden auf ${fixed(note.usedMm, 2)} mm umgerechnet. Kleine Einzelheiten können deshalb unscharf sein.`;
      case "positions":
        return `Die Lage der Schichten wich um bis zu ${fixed(note.mm, 2)} mm ab. Verwendet wurde der mittlere Abstand.`;
      case "missing":
        return `${count(note.count, "fehlende Schicht wurde", "fehlende Schichten wurden")} aus den Nachbarschichten ergänzt.`;
      case "duplicates":
        return `${count(note.count, "Schicht war", "Schichten waren")} doppelt vorhanden und wurde${note.count === 1 ? "" : "n"} nur einmal übernommen.`;
      case "overview":
        return `${count(note.count, "Übersichtsbild wurde", "Übersichtsbilder wurden")} ausgelassen.`;
      case "incomplete":
        return `${count(note.count, "unvollständige Phase wurde", "unvollständige Phasen wurden")} ausgelassen.`;
      case "uncommon":
        return `${count(note.count, "Schicht am Rand einiger Phasen wurde", "Schichten am Rand einiger Phasen wurden")} ausgelassen, weil sie in anderen Phasen fehlen.`;
      case "fewer":
        return `Von ${number.format(note.of)} Phasen wurden nur ${number.format(note.kept)} behalten, weil alle zusammen größer als erlaubt wären.`;
      case "size":
        return `${count(note.count, "Schicht mit anderer Größe wurde", "Schichten mit anderer Größe wurden")} ausgelassen.`;
      case "damaged":
        return `${count(note.count, "beschädigte oder unlesbare Datei wurde", "beschädigte oder unlesbare Dateien wurden")} ausgelassen.`;
      case "clipped":
        return `Werte über ${number.format(note.limit)} wurden abgeschnitten.`;
      case "scaled":
        return `Die Werte wurden zum Speichern mit ${number.format(note.factor)} multipliziert.`;
      case "directions":
        return "Die Datei sagt nicht, wie die Aufnahme im Körper liegt, darum können links und rechts vertauscht sein.";
      case "halved":
        return "Die Werte wurden zum Speichern halbiert.";
      case "brightness":
        return "Die Schichten hatten verschiedene Werteskalen und wurden auf eine gemeinsame umgerechnet.";
      case "negative":
        return "Das Negativ wurde in ein Positiv umgewandelt.";
    }
  },
  picture: (title) => `Bild von ${title}`,
  pictureBeingMade: "Das Bild wird gerade erstellt.",
  noPicture: "Noch kein Bild.",
};
