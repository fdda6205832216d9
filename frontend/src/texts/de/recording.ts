import type { Texts } from "..";
import { count, fixed } from "./counting";

export const recording: Texts["recording"] = {
  open: "Aufzeichnung",
  title: "Aufzeichnen, wie ich Bilder ansehe",
  lead: "Das hilft, Diaphane so schneller zu machen, wie Menschen es wirklich benutzen. Aufgezeichnet wird, wie Sie ein Bild drehen und sein Aussehen wählen, und wann: nicht Ihr Name, nicht welche Aufnahme, kein Bild. Aufzeichnungen werden nach 90 Tagen gelöscht, und wann immer Sie möchten.",
  consent: "Aufzeichnen, wie ich Bilder ansehe",
  item: (seconds, steps) => `${seconds < 60 ? `${seconds.toFixed(0)} s` : `${fixed(seconds / 60, 1)} min`}, ${count(steps, "Schritt", "Schritte")}`,
  export_one: "Herunterladen",
  delete_one: "Löschen",
};
