import type { Texts } from "../shape";
import { fixed } from "./counting";

export const slices: Texts["slices"] = {
  open: "Schichten zeigen (V)",
  close: "Nur die 3D-Ansicht zeigen (V)",
  bar: "Schichten",
  views: "Anordnung",
  view: { picture: "3D", four: "Alle", axial: "Axial", sagittal: "Sagittal", coronal: "Koronal" },
  tools: "Werkzeug",
  tool: { window: "Fenster", crosshair: "Fadenkreuz", ruler: "Lineal", angle: "Winkel" },
  toolHelp: {
    window: "Ziehen Sie seitwärts, um den Kontrast zu ändern, und auf oder ab, um die Helligkeit zu ändern.",
    crosshair:
      "Ziehen, klicken oder tippen Sie, um alle drei Schichten durch diese Stelle zu legen. Mit der Maus geht das jederzeit auch, wenn Sie die Umschalttaste halten und den Zeiger bewegen.",
    ruler:
      "Ziehen Sie von einem Punkt zum anderen, oder klicken oder tippen Sie beide an. Mit der Tastatur setzt die Eingabetaste einen Punkt am Fadenkreuz.",
    angle:
      "Klicken oder tippen Sie drei Punkte an. Der zweite ist der Scheitelpunkt. Mit der Tastatur setzt die Eingabetaste einen Punkt am Fadenkreuz.",
  },
  usual: "Fenster",
  usualOwn: "Benutzerdefiniert",
  usualWindows: { soft: "Weichteile", lung: "Lunge", bone: "Knochen", brain: "Gehirn" },
  centre: "Zentrum",
  width: "Weite",
  removeMeasure: "Letzte Messung löschen",
  reset: "Schichten zurücksetzen",
  maximise: (view) => `Nur ${view} zeigen (M)`,
  restore: "Alle Ansichten zeigen (M)",
  canvas: (view) =>
    `${view}e Schicht. Die Pfeile auf und ab oder Bild auf und Bild ab blättern durch die Schichten, Umschalt und Pfeile bewegen das Fadenkreuz, Strg und Pfeile verschieben die Schicht, Plus und Minus zoomen, M zeigt nur diese Schicht, und R setzt die Schichten zurück.`,
  slider: (view) => `${view}e Schicht`,
  number: (index, count) => `${index} von ${count}`,
  title: (view, index, count) => `${view} ${index}/${count}`,
  place: (parts) => `${parts.map(({ side, mm }) => `${side} ${fixed(mm, 1)}`).join("  ")} mm`,
  hu: (value) => `${value} HE`.replace("-", "−"),
  value: (value) => `Wert ${value}`.replace("-", "−"),
  cutAway: "Weggeschnitten",
  nothing: "Außerhalb der Aufnahme",
  ruler: (mm) => `${fixed(mm, 1)} mm`,
  angle: (degrees) => `${fixed(degrees, 1)}°`,
  said: (title, value, place) => `${title}, ${value}, ${place}`,
  unsupported:
    "Dieser Browser ist zu alt, um die Schichten zu zeigen. Aktualisieren Sie ihn, oder verwenden Sie einen anderen Browser.",
  damaged: "Eine Schicht wurde bei der Übertragung beschädigt. Laden Sie die Seite neu, um sie noch einmal zu laden.",
};
