import type { Texts } from "../shape";
import { count } from "./counting";

/** Leaves out what there is none of, unless there is neither. */
const both = (marks: number, measures: number): string =>
  [
    marks > 0 || measures === 0 ? count(marks, "Markierung", "Markierungen") : "",
    measures > 0 ? count(measures, "Messung", "Messungen") : "",
  ]
    .filter(Boolean)
    .join(" und ");

export const marks: Texts["marks"] = {
  lead: "Wählen Sie, was Sie hinzufügen möchten, und drücken Sie dann auf eine Stelle im Bild oder in einer Schicht. Ziehen Sie, um die Größe festzulegen. Eine Markierung bleibt an ihrer Stelle in der Aufnahme und ist gestrichelt, solange etwas davor liegt.",
  kinds: { arrow: "Pfeil", circle: "Kreis", text: "Text", ruler: "Lineal", angle: "Winkel" },
  press: {
    arrow: "Drücken Sie auf die Stelle, auf die der Pfeil zeigen soll, und ziehen Sie bis zu seinem Anfang.",
    circle: "Drücken Sie auf die Mitte des Kreises, und ziehen Sie bis zu seinem Rand.",
    text: "Drücken Sie auf die Stelle, um die es im Text geht.",
    ruler:
      "Drücken Sie auf zwei Punkte, oder ziehen Sie von einem zum anderen. Im Bild liegt ein Punkt auf der Oberfläche dort, auf etwa 1 % der Größe der Aufnahme genau.",
    angle:
      "Drücken Sie auf drei Punkte. Der zweite ist der Scheitelpunkt. Im Bild liegt ein Punkt auf der Oberfläche dort, auf etwa 1 % der Größe der Aufnahme genau.",
  },
  nextPoint: (point, count) => `Drücken Sie nun auf Punkt ${point} von ${count}.`,
  nothingThere: "An dieser Stelle ist nichts von der Aufnahme. Wählen Sie eine andere.",
  full: "Sie können höchstens 50 Markierungen gleichzeitig zeigen. Löschen Sie erst welche, oder blenden Sie welche aus.",
  colour: "Farbe",
  colours: ["Orange", "Blau", "Rosa", "Grün", "Gelb", "Violett", "Türkis", "Rot"],
  text: "Text",
  textHint:
    "Alle, denen Sie diese Markierung zeigen, können den Text lesen. Schreiben Sie keinen Namen hinein, den sie nicht sehen sollen.",
  shown: "Meine Markierungen zeigen",
  here: "Markierungen im Bild",
  none: "Es gibt noch keine Markierungen.",
  nameOf: (kind, text) =>
    text || { arrow: "Pfeil", circle: "Kreis", text: "Leerer Text", ruler: "Lineal", angle: "Winkel" }[kind],
  by: (name) => `von ${name}`,
  keep: "Kopie behalten",
  keepOf: (mark) => `Kopie behalten: ${mark}`,
  remove: "Löschen",
  removeOf: (mark) => `Löschen: ${mark}`,
  choose: (mark) => `Auswählen: ${mark}`,
  moveOf: (mark) => `Verschieben: ${mark}`,
  tailOf: (mark) => `Anfang verschieben: ${mark}`,
  secondOf: (mark) => `Zweiten Punkt verschieben: ${mark}`,
  thirdOf: (mark) => `Dritten Punkt verschieben: ${mark}`,
  edgeOf: (mark) => `Größe ändern: ${mark}`,
  guestsOff: "Die Markierungen der Gäste sind gerade ausgeschaltet. Ihre sehen daher nur Sie.",
  saved: {
    title: "Mit dieser Aufnahme gespeichert",
    lead: "Was Sie hier speichern, sehen nur Sie, solange Sie es nicht teilen.",
    leadShared: "Diese Markierungen gehören zu der Aufnahme und stammen von der Person, der sie gehört.",
    unsaved: (marks, measures) => `Noch nicht gespeichert: ${both(marks, measures)}.`,
    name: "Name",
    save: "Speichern",
    added: (name) => `Als ${name} gespeichert. Spätere Änderungen werden von selbst gespeichert.`,
    content: (marks, measures) => both(marks, measures),
    share: "Für alle sichtbar, die diese Aufnahme öffnen können",
    shareHint:
      "Geteilte Markierungen sehen alle, mit denen Sie die Aufnahme teilen, auch ohne Konto über einen Link. Ist sie öffentlich, sind sie auch in der Galerie zu sehen.",
    shared: "geteilt",
    rename: "Umbenennen",
    renameOf: (name) => `${name} umbenennen`,
    newName: "Neuer Name",
    remove: "Löschen",
    removeOf: (name) => `${name} löschen`,
    removeSure: (name) => `„${name}“ mit allen Markierungen und Messungen endgültig löschen?`,
  },
  include: (marks, measures) => `Mit ${both(marks, measures)}`,
  inPicture: {
    include: (marks) => `${count(marks, "Markierung", "Markierungen")} ins Bild zeichnen`,
    hint: "Die Texte der Markierungen sind dann im Bild zu lesen.",
  },
  inVideo: {
    include: (marks) => `${count(marks, "Markierung", "Markierungen")} ins Video zeichnen`,
    hint: "Die Markierungen bleiben an ihren Stellen der Aufnahme. Ihre Texte sind dann im Video zu lesen.",
  },
  includeHint: "Alle, die das öffnen, können die Texte der Markierungen lesen.",
};
