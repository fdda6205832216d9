import type { Texts } from "../shape";

export const live: Texts["live"] = {
  open: "Gemeinsam ansehen",
  openHere: (people) => `Gemeinsam ansehen, ${people} Personen dabei`,
  title: "Gemeinsam ansehen",
  lead: "Wer den Link hat, sieht dieses Bild so, wie Sie es drehen, und sieht, wer sonst noch da ist. Alle können es auch selbst drehen. Was Sie weggeschnitten haben, ist nicht zu sehen, und auch keine andere Ihrer Aufnahmen. Ein Konto ist nicht nötig. Der Link gilt 12 Stunden oder bis Sie ihn deaktivieren.",
  guestLead: "Sie sehen das Bild so, wie es gerade präsentiert wird.",
  makeLink: "Link erstellen",
  link: "Link zum Weitergeben",
  copy: "Kopieren",
  copied: "Kopiert.",
  endLink: "Link deaktivieren",
  guestSlices: "Gäste dürfen auch die Schichten sehen",
  guestSlicesHint:
    "Sie sehen dann die genauen Werte der Aufnahme, aber nichts, was Sie weggeschnitten haben. Sie können das jederzeit wieder ausschalten.",
  guestPointers: "Gäste dürfen auf Stellen zeigen",
  pointHint:
    "Alle sehen, worauf Sie zeigen. Bewegen Sie die Maus über das Bild oder eine Schicht, oder halten Sie einen Finger darauf.",
  ended: "Der Link ist deaktiviert. Alle Verbindungen darüber wurden getrennt.",
  here: "Wer ist dabei?",
  you: " (Sie)",
  owner: "Besitzer",
  presenting: "präsentiert",
  withFreeCamera: "mit eigener Ansicht",
  handOver: "Präsentation übergeben",
  handOverHint:
    "Wer präsentiert, kann alles am Bild ändern. Was Sie weggeschnitten haben, bleibt weggeschnitten. Sie können jederzeit wieder selbst präsentieren.",
  letPresent: (name) => `Präsentation übergeben: ${name}`,
  takeBack: "Wieder selbst präsentieren",
  takingBack: "Einen Moment …",
  presents: (name) => `${name} präsentiert`,
  presenterAway: "Gerade präsentiert niemand",
  freeCamera: "Meine eigene Ansicht",
  noFreeCamera:
    "Eine eigene Ansicht ist gerade nicht möglich, weil der Server ausgelastet ist. Versuchen Sie es später noch einmal.",
  freeCameraTaken:
    "Ihre eigene Ansicht wurde geschlossen, weil jemand mit einem Konto den Platz braucht. Sie sehen wieder das Bild, das gerade präsentiert wird.",
  joinTitle: "Eine Aufnahme gemeinsam ansehen",
  joinLead: "Jemand teilt das Bild einer Aufnahme mit Ihnen. Sie sehen es so, wie es gerade gedreht wird.",
  name: "Ihr Name (sichtbar für die anderen)",
  nameHint: "Freiwillig. Sie können einen beliebigen Namen verwenden.",
  join: "Teilnehmen",
  guestTitle: "Geteiltes Bild",
};
