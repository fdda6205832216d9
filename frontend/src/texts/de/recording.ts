import type { Texts } from "../shape";
import { count, fixed } from "./counting";

export const recording: Texts["recording"] = {
  open: "Nutzungsaufzeichnung",
  title: "Nutzungsaufzeichnung",
  lead: "Damit helfen Sie uns, Diaphane dort schneller zu machen, wo es im Alltag darauf ankommt. Wir zeichnen auf, wie und wann Sie die Ansicht drehen und die Darstellung wechseln. Wir zeichnen weder Ihren Namen noch Bilder auf, und auch nicht, welche Aufnahme Sie sich ansehen. Aufzeichnungen werden nach 90 Tagen gelöscht, und Sie können sie jederzeit selbst löschen.",
  consent: "Aufzeichnen, wie ich die Ansicht bediene",
  item: (seconds, steps) =>
    `${seconds < 60 ? `${seconds.toFixed(0)} s` : `${fixed(seconds / 60, 1)} min`}, ${count(steps, "Schritt", "Schritte")}`,
  exportOne: "Herunterladen",
  deleteOne: "Löschen",
};
