import type { Texts } from "../shape";
import { count, number } from "./counting";
import { scans } from "./scans";

const minutes = (seconds: number) => count(Math.max(1, Math.round(seconds / 60)), "Minute", "Minuten");
const hours = (seconds: number) => count(Math.round(seconds / 3600), "Stunde", "Stunden");

/** Returns a duration in words that lies between two numbers of seconds. */
function between(least: number, most: number): string {
  if (most < 50) return "weniger als eine Minute";
  const last = most < 5400 ? minutes(most) : hours(most);
  if (least < 50) return `bis zu ${last}`;
  const first = least < 5400 ? minutes(least) : hours(least);
  if (first === last) return `etwa ${last}`;
  const alike = least < 5400 === most < 5400; // "4 bis 12 Minuten" says the unit once
  return `etwa ${alike ? first.split(" ")[0] : first} bis ${last}`;
}

export const take: Texts["take"] = {
  title: "Speichern oder teilen",
  file: "Datei speichern",
  what: "Dateityp",
  kinds: {
    picture: "Bild",
    turntable: "Video einer vollen Drehung",
    around: "Video des Rundgangs",
    tour: "Videotour durch gespeicherte Voreinstellungen",
    phases: "Video der Phasen",
  },
  picture: "Bild speichern",
  pictureLead:
    "Wir berechnen das Bild in der gewählten Größe neu, und Sie können inzwischen weitermachen. Die Datei enthält nur das Bild: keinen Namen, kein Datum und keinen Hinweis darauf, von welcher Aufnahme es stammt.",
  pictureNow:
    "Das Bild wird sofort gespeichert, genau wie Sie es sehen. Die Datei enthält nur das Bild: keinen Namen, kein Datum und keinen Hinweis darauf, von welcher Aufnahme es stammt.",
  onlyScreen:
    "Videos und größere Bilder dieser Aufnahme können Sie nicht speichern. Das kann nur die Person erlauben, der die Aufnahme gehört.",
  size: "Größe",
  sizes: {
    screen: (width, height) => `Wie angezeigt, ${width} × ${height}`,
    large: (width, height) => `Groß, ${width} × ${height}`,
    largest: (width, height) => `Sehr groß, ${width} × ${height}`,
    poster: (width, height) => `Poster, ${width} × ${height} (dauert lange)`,
    other: "Eigene Größe",
  },
  width: "Breite",
  height: "Höhe",
  wrongSize: (least, most) =>
    `Jede Seite muss ${least} bis ${number.format(most)} Bildpunkte lang sein. Geben Sie ganze Zahlen ein.`,
  otherHint: "Die Höhe des Bildausschnitts bleibt gleich. An den Seiten wird er beschnitten oder erweitert.",
  quality: "Qualität",
  qualities: {
    quick: "Entwurf, etwas körnig",
    good: "Gut, kaum noch körnig",
    best: "Fertig (dauert am längsten)",
  },
  timeHint: "Das verbraucht Rechenzeit.",
  save: "Bild speichern",
  ofPicture: {
    rendering: "Das Bild wird berechnet",
    saved: "Das Bild wurde gespeichert.",
    stopped: "Es wurde kein Bild gespeichert.",
    failed: "Das Bild konnte nicht berechnet werden. Versuchen Sie es noch einmal.",
  },
  ofVideo: {
    rendering: "Das Video wird berechnet",
    saved: "Das Video wurde gespeichert.",
    stopped: "Es wurde kein Video gespeichert.",
    failed: "Das Video konnte nicht berechnet werden. Versuchen Sie es noch einmal.",
  },
  busy: "Der Server berechnet gerade Dateien für andere. Versuchen Sie es in ein paar Minuten noch einmal.",
  hide: "Diese Meldung ausblenden",
  turntableLead:
    "Was Sie gerade sehen, einmal um die Längsachse des Körpers gedreht. Das Video läuft ohne Sprung in einer Schleife. Die Datei enthält nur die Bilder: keinen Namen, kein Datum und keinen Hinweis darauf, von welcher Aufnahme sie stammen.",
  aroundLead:
    "Was Sie gerade sehen, in einem langsamen Rundgang durch die Ansichten, die am meisten davon zeigen. Die Datei enthält nur die Bilder: keinen Namen, kein Datum und keinen Hinweis darauf, von welcher Aufnahme sie stammen.",
  phasesLead:
    "Was Sie gerade sehen, während die Phasen der Aufnahme abgespielt werden. Das Video läuft endlos ohne sichtbaren Übergang. Die Datei enthält nur die Bilder: keinen Namen, kein Datum und keinen Hinweis darauf, von welcher Aufnahme sie stammen.",
  tourLead:
    "Ein fließender Übergang von einer gespeicherten Voreinstellung zur nächsten: Blickpunkt, Farben und Lichter ändern sich allmählich. Die Datei enthält nur die Bilder: keinen Namen, kein Datum und keinen Hinweis darauf, von welcher Aufnahme sie stammen.",
  seconds: "Länge in Sekunden",
  rate: "Bilder pro Sekunde",
  videoSizes: {
    small: (width, height) => `Klein, ${width} × ${height}`,
    medium: (width, height) => `Mittel, ${width} × ${height}`,
    large: (width, height) => `Groß, ${width} × ${height}`,
  },
  videoHint: (frames) =>
    frames > 0
      ? `Für dieses Video ${frames === 1 ? "wird" : "werden"} ${count(frames, "Bild", "Bilder")} berechnet. Das verbraucht Rechenzeit.`
      : "Das verbraucht Rechenzeit.",
  videoTime: (time) =>
    time === null
      ? "Sobald das Bild schärfer ist, steht hier, wie lange es dauern wird."
      : `Es dauert ${between(time.least, time.most)}, und länger, solange jemand ein Bild dreht. Während der Berechnung sehen Sie, wie lange es noch dauert.`,
  framesBegun: (done, all) =>
    done === 0 ? `Das erste von ${count(all, "Bild", "Bildern")} wird berechnet.` : `${done} von ${all}`,
  framesDone: (done, all, left) => `${done} von ${all}, ${scans.upload.left(left)}`,
  wrongSeconds: (least, most) => `Geben Sie eine ganze Zahl von ${least} bis ${most} Sekunden ein.`,
  views: "Ansichten in dieser Reihenfolge",
  viewNow: "Aktuelle Ansicht",
  noViews:
    "Für diese Aufnahme sind noch keine Voreinstellungen gespeichert. Speichern Sie einige mit dem Stern oben, eine für jede Ansicht, die in der Tour vorkommen soll.",
  wrongViews: (most) => `Wählen Sie 2 bis ${most} Ansichten für die Tour.`,
  earlier: "Nach oben",
  earlierOf: (name) => `${name} nach oben`,
  saveVideo: "Video speichern",
  link: "Link zu dieser Ansicht teilen",
  linkLead:
    "Wer die Aufnahme schon öffnen darf, sieht sie, wie sie jetzt ist: mit Ihren Farben, Lichtern, Schnitten und Ihrem Blickwinkel. Andere erhalten durch den Link keinen Zugriff auf die Aufnahme. Er enthält die Namen Ihrer Lichter und Materialien, aber nicht den Namen des Patienten oder der Patientin.",
  linkWithoutPatterns: "Ihre eigenen Bilder als Lichtmuster sind in dem Link nicht enthalten.",
  linkField: "Link",
  linkTooLarge:
    "Diese Ansicht enthält zu viele Einzelheiten für einen Link. Speichern Sie sie stattdessen als Voreinstellung.",
  copy: "Kopieren",
  copied: "Kopiert.",
  notCopied: "Der Link konnte nicht kopiert werden. Markieren Sie ihn und kopieren Sie ihn selbst.",
  linkDamaged: "Dieser Link ist beschädigt oder unvollständig. Die Aufnahme wird deshalb wie gewohnt gezeigt.",
  linkNewer:
    "Dieser Link stammt aus einer neueren Version von Diaphane. Die Aufnahme wird deshalb wie gewohnt gezeigt. Laden Sie die Seite neu und versuchen Sie es noch einmal.",
};
