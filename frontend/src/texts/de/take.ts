import type { Texts } from "..";
import type { Soon } from "../shape";
import { number } from "./counting";

export const take: Soon<Texts["take"]> = {
  title: "Mitnehmen",
  picture: "Ein Bild",
  picture_lead: "Es wird in der gewählten Größe neu berechnet, während Sie weiter zusehen. Die Datei enthält das Bild und sonst nichts: keinen Namen, kein Datum, nicht welche Aufnahme.",
  picture_now: "Das Bild, wie es auf dem Bildschirm ist, ohne einen Namen darin.",
  size: "Größe",
  sizes: {
    screen: (width, height) => `Wie auf dem Bildschirm, ${width} × ${height}`,
    large: (width, height) => `Groß, ${width} × ${height}`,
    largest: (width, height) => `So groß wie möglich, ${width} × ${height}`,
    other: "Eine andere",
  },
  width: "Breite",
  height: "Höhe",
  wrong_size: (least, most) => `Ein Bild hat ${least} bis ${number.format(most)} Bildpunkte je Seite. Bitte geben Sie ganze Zahlen ein.`,
  other_hint: "Von oben nach unten so viel wie auf dem Bildschirm; an den Seiten mehr oder weniger.",
  quality: "Wie sauber",
  qualities: { quick: "Schnell, Fehler 5 %", good: "Gut, Fehler 2 %", best: "Fertig und verlustfrei; dauert am längsten" },
  time_hint: "Das kostet von Ihrer Bildzeit.",
  save: "Das Bild speichern",
  rendering: "Das Bild wird berechnet",
  saved: "Das Bild ist gespeichert.",
  hide: "Ausblenden",
  stopped: "Es wurde kein Bild gespeichert.",
  failed: "Das Bild konnte nicht erstellt werden.",
  link: "Ein Link zu dem, was Sie sehen",
  link_lead: "Er führt alle, die diese Aufnahme sehen dürfen, zu ihr, wie sie jetzt ist: Farben, Lichter, Schnitte und von wo Sie schauen. Er öffnet die Aufnahme niemandem, und es steht kein Name darin.",
  link_field: "Der Link",
  link_too_large: "In diesem Bild ist mehr, als in einen Link passt. Speichern Sie es als Voreinstellung.",
  copy: "Kopieren",
  copied: "Kopiert.",
  not_copied: "Der Browser hat das Kopieren nicht erlaubt. Markieren Sie den Link und kopieren Sie ihn selbst.",
  link_damaged: "Der Link ist beschädigt oder abgeschnitten: Die Aufnahme wird wie gewohnt gezeigt.",
  link_newer: "Der Link stammt von einem neueren Diaphane: Die Aufnahme wird wie gewohnt gezeigt. Laden Sie die Seite neu und versuchen Sie es noch einmal.",
};
