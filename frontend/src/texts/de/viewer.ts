import type { Texts } from "../shape";
import { count, fixed, number } from "./counting";

export const viewer: Texts["viewer"] = {
  lostEnvironment: "Die Umgebung dieser Ansicht existiert nicht mehr. Ein gleichmäßiges Licht ersetzt sie.",
  back: "Meine Aufnahmen",
  stage: (looks) =>
    `3D-Ansicht der Aufnahme. Die Pfeiltasten drehen, Plus und Minus zoomen, R setzt die Ansicht zurück, ${looks > 1 ? `1 bis ${looks} wählen eine Darstellung, ` : ""}und das Fragezeichen zeigt alle Tasten.`,
  first: "Das Bild wird vorbereitet …",
  troubles: {
    lost: "Verbindung unterbrochen. Sie wird wiederhergestellt …",
    worker_lost: "Der Renderserver ist ausgefallen. Die Verbindung wird wiederhergestellt …",
    no_worker: "Alle Renderserver sind gerade belegt. Wir versuchen es weiter …",
    unreachable: "Diaphane ist nicht erreichbar. Wir versuchen es weiter …",
    refused: "Etwas ist schiefgegangen. Wir versuchen es weiter …",
    not_ready: "Diese Aufnahme wird noch vorbereitet. Das Bild erscheint dann von selbst.",
    not_found: "Diese Aufnahme gibt es nicht, oder Sie haben keinen Zugriff darauf.",
    signed_out: "Sie sind abgemeldet. Melden Sie sich wieder an, um weiterzumachen.",
    taken_over: "Dieses Bild ist jetzt in einem anderen Fenster geöffnet.",
    time_spent: "Ihre Rechenzeit für diesen Monat ist aufgebraucht.",
    link_ended:
      "Dieser Link ist abgelaufen oder wurde deaktiviert. Bitten Sie die Person, die ihn geteilt hat, um einen neuen.",
    displaced:
      "Diaphane ist ausgelastet, und wer ein Konto hat, hat Vorrang. Melden Sie sich an, oder laden Sie diese Seite in ein paar Minuten neu.",
  },
  meanwhile: "Bis dahin bleibt das Bild, wie es ist.",
  continueHere: "Hier weitermachen",
  treatment: {
    tableHidden: "Liege, Kopfstütze oder Rahmen sind ausgeblendet.",
    showTable: "Einblenden",
    close: "Diesen Hinweis schließen",
    interpolated: (between) =>
      `Die Schichten dieser Aufnahme liegen weit auseinander. Das Bild zeigt zwischen je zwei Schichten ${between === 1 ? "eine berechnete" : `${between} berechnete`}.`,
  },
  pictureTime: {
    soon: (minutes) =>
      `Sie haben in diesem Monat noch ${minutes > 1 ? `etwa ${count(minutes, "Minute", "Minuten")}` : "weniger als eine Minute"} Rechenzeit. Fertige Bilder verbrauchen keine Rechenzeit.`,
    ending: (at, reset) =>
      `Ihre Rechenzeit für diesen Monat ist aufgebraucht. Dieses Bild bleibt bis ${at} geöffnet. Am ${reset} wird Ihre Rechenzeit zurückgesetzt.`,
    over: "Keine Rechenzeit mehr",
    overText: (reset) =>
      `Ihre Rechenzeit für diesen Monat ist aufgebraucht. Am ${reset} wird sie zurückgesetzt. Ihre Aufnahmen bleiben erhalten, und nichts geht verloren.`,
    overBefore:
      "Ihre Rechenzeit für diesen Monat ist aufgebraucht. Ihre Aufnahmen bleiben erhalten, und nichts geht verloren.",
    more: "Die Administration kann Ihr Limit erhöhen.",
    hide: "Diese Meldung ausblenden",
    account: "Verbrauch ansehen",
  },
  notMedical: "Kein Medizinprodukt. Nicht zur Diagnose.",
  visitor: {
    back: "Zurück",
    invite: "Konto erstellen",
    over: "Ihr Besuch ist zu Ende",
    overText: {
      sample: "Ein Beispiel können Sie jeweils 20 Minuten lang ansehen, damit auch andere an die Reihe kommen.",
      link: "Die Zeit für diesen Besuch ist um, oder der Link ist abgelaufen oder wurde deaktiviert. Wenn er sich nicht mehr öffnen lässt, bitten Sie die Person, die ihn geteilt hat, um einen neuen.",
      session:
        "Dieser Link ist abgelaufen oder wurde deaktiviert. Bitten Sie die Person, die ihn geteilt hat, um einen neuen.",
    },
    inviteText: "Mit einem eigenen Konto können Sie Ihre eigenen Aufnahmen ansehen, so lange Sie möchten.",
    again: "Noch einmal ansehen",
    toSamples: "Zurück zu den Beispielen",
  },
  hints: {
    title: (n, all) => `Tipp ${n} von ${all}`,
    all: [
      "Ziehen Sie am Bild, um es zu drehen. Mit zwei Fingern oder dem Mausrad zoomen Sie.",
      "Die Bilder unten zeigen andere Darstellungen derselben Aufnahme.",
      "Licht, Objektiv und Schnitte finden Sie im Menü links. Jede Änderung lässt sich rückgängig machen.",
    ],
    touch: "Ziehen Sie mit einem Finger am Bild, um es zu drehen. Mit zwei Fingern zoomen Sie.",
    next: "Weiter",
    done: "Verstanden",
    hide: "Tipps ausblenden",
  },
  presets: "Darstellungen",
  lookOfCt: {
    skin: "Haut",
    muscle: "Muskeln",
    vessels: "Gefäße",
    bone: "Knochen",
    through: "Glas",
    dense: "Zähne",
    airways: "Luftwege",
  },
  lookOfOther: {
    brain: "Gehirn",
    through: "Glas",
    skin: "Oberfläche",
    muscle: "Weichgewebe",
    vessels: "Hellste Teile",
    bone: "Helle Teile",
    airways: "Durchsichtig",
  },
  reset: "Ansicht zurücksetzen",
  fullscreen: "Vollbild",
  screenshot: "Speichern oder teilen",
  help: "Bedienung",
  quality: "Qualität",
  qualityOpen: "Qualität anzeigen",
  details: "Details",
  samples: "Samples",
  error: "Rauschen",
  errorUnknown: "wird gemessen …",
  errorHelp:
    "Wie weit das Bild im Mittel noch vom fertigen abweichen kann. Mit viermal so vielen Samples halbiert sich dieser Wert.",
  time: "Zeit",
  perSecond: (n) => `${n < 10 ? fixed(n, 1) : number.format(Math.round(n))} pro Sekunde`,
  plot: "Rauschen im Lauf der Zeit, beide Achsen logarithmisch",
  finished: "Fertig",
  lossless: (samples) => `Verlustfrei, ${count(samples, "Sample", "Samples")}`,
  losslessHelp:
    "Jeder Bildpunkt ist genau so, wie der Renderer ihn berechnet hat. Dieser Browser hat geprüft, dass bei der Übertragung nichts verloren ging.",
  tileDamaged: "Das fertige Bild wurde bei der Übertragung beschädigt. Stattdessen sehen Sie das gestreamte Bild.",
  refining: (part) => (part === null ? "Wird schärfer …" : `Wird schärfer …\u00a0${Math.floor(100 * part)}\u00a0%`),
  smoothedHelp: "Dieses Bild ist entrauscht, weil es sonst noch körnig wäre. Das fertige Bild wird nie entrauscht.",
  seconds: (s) => (s < 1 ? `${(s * 1000).toFixed(0)} ms` : s < 100 ? `${fixed(s, 1)} s` : `${fixed(s / 60, 1)} min`),
  percent: (error) =>
    `${new Intl.NumberFormat("de", { minimumSignificantDigits: 2, maximumSignificantDigits: 2 }).format(100 * error)} %`,
  orientation: (side) => `Ansicht von ${side}`,
  viewFrom: (side) => `Von ${side} ansehen`,
  sides: {
    L: "links (vom Patienten aus)",
    R: "rechts (vom Patienten aus)",
    A: "vorn",
    P: "hinten",
    S: "oben",
    I: "unten",
  },
  noCodec:
    "Dieser Browser kann die Bilder nicht anzeigen. Aktualisieren Sie ihn, oder verwenden Sie einen anderen Browser.",
  helpRows: (looks) => [
    ["Drehen", "Mit der linken Taste ziehen", "Mit einem Finger ziehen", "Pfeiltasten"],
    [
      "Verschieben",
      "Mit der mittleren Taste ziehen oder Umschalt + Ziehen",
      "Mit zwei Fingern ziehen",
      "Umschalt + Pfeiltasten",
    ],
    ["Zoomen", "Mausrad oder mit der rechten Taste ziehen", "Zwei Finger spreizen oder zusammenziehen", "+ und −"],
    ["Rollen", "Strg + Ziehen", "", "Strg + ← →"],
    ["Ansicht zurücksetzen", "Knopf oben", "Knopf oben", "R"],
    ...(looks > 1 ? [["Darstellung wählen", "Bilder unten", "Bilder unten", `1 bis ${looks}`] as const] : []),
    ["Rückgängig machen", "Menü links", "Menü links", "Strg + Z"],
    ["Wiederholen", "Menü links", "Menü links", "Strg + Umschalt + Z"],
    ["Schichten zeigen", "Knopf oben", "Knopf oben", "V"],
    [
      "In einer Schicht messen",
      "Lineal, Winkel oder Ellipse, dann ziehen",
      "Lineal, Winkel oder Ellipse, dann ziehen",
      "Eingabe",
    ],
    ["Weiche oder farbige Schichten", "„Weich“ und „Farben“ darüber", "„Weich“ und „Farben“ darüber", "Leertaste"],
    ["Vollbild", "Knopf oben", "", "F"],
    ["Speichern oder teilen", "Knopf oben", "Knopf oben", "S"],
  ],
  helpButtons: { title: "Knöpfe", slices: "Schichten zeigen" },
  helpHeads: ["Aktion", "Maus", "Touch", "Tastatur"],
};
