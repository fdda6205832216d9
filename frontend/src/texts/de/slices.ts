import type { Texts } from "../shape";
import { count, fixed, number } from "./counting";

/** Writes a typographic minus. */
const signed = (text: string): string => text.replace("-", "−");
/** Adds the unit to the values of a CT, which are in Hounsfield units. */
const withUnit = (text: string, hounsfield: boolean): string => `${signed(text)}${hounsfield ? " HE" : ""}`;

export const slices: Texts["slices"] = {
  open: "Schichten zeigen (V)",
  close: "Nur die 3D-Ansicht zeigen (V)",
  bar: "Schichten",
  views: "Anordnung",
  view: { picture: "3D", four: "Alle", axial: "Axial", sagittal: "Sagittal", coronal: "Koronal" },
  tools: "Werkzeug",
  tool: {
    window: "Fenster",
    crosshair: "Fadenkreuz",
    tilt: "Kippen",
    curve: "Kurve",
    ruler: "Lineal",
    angle: "Winkel",
    ellipse: "Ellipse",
  },
  toolHelp: {
    window: "Ziehen Sie seitwärts, um den Kontrast zu ändern, und auf oder ab, um die Helligkeit zu ändern.",
    crosshair:
      "Ziehen, klicken oder tippen Sie, um alle drei Schichten durch diese Stelle zu legen. Mit der Maus geht das jederzeit auch, wenn Sie die Umschalttaste halten und den Zeiger bewegen.",
    tilt: "Zeigt auch die Dicke von Schichten. Ziehen Sie um das Fadenkreuz herum, um die anderen beiden Ebenen zu drehen. Mit der Tastatur drehen Komma und Punkt sie.",
    curve:
      "Klicken oder tippen Sie Punkte entlang eines Gefäßes, des Kiefers oder der Wirbelsäule an, auch in verschiedenen Schichten. Die Schicht entlang der Punkte erscheint gestreckt. Ziehen Sie einen Punkt, um ihn zu verschieben. Mit der Tastatur setzt die Eingabetaste einen Punkt am Fadenkreuz, und die Rücktaste entfernt den letzten.",
    ruler:
      "Ziehen Sie von einem Punkt zum anderen, oder klicken oder tippen Sie beide an. Ziehen Sie ein Ende, um es zu verschieben. Mit der Tastatur setzt die Eingabetaste einen Punkt am Fadenkreuz oder nimmt den Punkt dort auf.",
    angle:
      "Klicken oder tippen Sie drei Punkte an. Der zweite ist der Scheitelpunkt. Ziehen Sie einen Punkt, um ihn zu verschieben. Mit der Tastatur setzt die Eingabetaste einen Punkt am Fadenkreuz oder nimmt den Punkt dort auf.",
    ellipse:
      "Misst die Werte in einer Ellipse. Ziehen Sie von einer Ecke zur gegenüberliegenden, oder klicken oder tippen Sie beide an. Ziehen Sie die Mitte, um die Ellipse zu verschieben, und einen Punkt am Rand, um ihre Größe zu ändern. Mit der Tastatur setzt die Eingabetaste eine Ecke am Fadenkreuz oder nimmt den Punkt dort auf.",
  },
  usual: "Fenster",
  usualOwn: "Eigene",
  usualWindows: { soft: "Weichteile", lung: "Lunge", bone: "Knochen", brain: "Gehirn" },
  centre: "Zentrum",
  width: "Weite",
  oblique: "Dicke und Kippung",
  slab: "Dicke, mm",
  slabHelp:
    "Die Dicke der Schichten in mm. Jedes Pixel fasst dann die Werte über die Dicke zusammen. 0 zeigt dünne Schichten.",
  projection: "Werte über die Dicke",
  projections: { mean: "Mittelwert", maximum: "Maximum", minimum: "Minimum" },
  straighten: "Kippung aufheben",
  tilted: (degrees) => `${fixed(degrees, 1)}° gekippt`,
  thick: (mm, projection) => `${projection} über ${number.format(mm)} mm`,
  both: (first, second) => `${first}, zweite Aufnahme: ${second}`,
  interpolated: (value) => `${value}, interpoliert`,
  removeMeasure: "Letzte Messung löschen",
  reset: "Schichten zurücksetzen",
  maximise: (view) => `Nur ${view} zeigen (M)`,
  restore: "Alle Ansichten zeigen (M)",
  canvas: (view) =>
    `${view}e Schicht. Die Pfeiltasten auf und ab oder Bild auf und Bild ab blättern durch die Schichten. Umschalt mit einer Pfeiltaste bewegt das Fadenkreuz. Strg mit einer Pfeiltaste verschiebt das Bild. Plus und Minus zoomen. Komma und Punkt kippen die anderen beiden Ebenen. M zeigt nur diese Schicht. R setzt die Schichten zurück.`,
  slider: (view) => `${view}e Schicht`,
  number: (index, count) => `${index} von ${count}`,
  title: (view, index, count) => `${view} ${index}/${count}`,
  place: (parts) => `${parts.map(({ side, mm }) => `${side} ${fixed(mm, 1)}`).join("  ")} mm`,
  hu: (value) => withUnit(String(value), true),
  value: (value) => signed(`Wert ${value}`),
  cutAway: "Weggeschnitten",
  nothing: "Außerhalb der Aufnahme",
  ruler: (mm) => `${fixed(mm, 1)} mm`,
  angle: (degrees) => `${fixed(degrees, 1)}°`,
  ellipse: (mean, deviation, hounsfield) =>
    `Mittel ${withUnit(`${fixed(mean, 1)} ± ${fixed(deviation, 1)}`, hounsfield)}`,
  ellipseRange: (minimum, maximum, hounsfield) =>
    `${signed(String(minimum))} bis ${withUnit(String(maximum), hounsfield)}`,
  ellipseSize: (area, pixels) =>
    `${area < 100 ? fixed(area, 1) : number.format(Math.round(area))} mm², ${count(pixels, "Pixel", "Pixel")}`,
  ellipseEmpty: "Keine Werte darin",
  held: "Aufgenommen. Umschalt und Pfeile verschieben den Punkt, die Eingabetaste legt ihn ab.",
  curve: {
    name: "Gekrümmte Schicht",
    hint: "Drücken Sie in beliebigen Schichten auf mindestens zwei Punkte entlang einer Struktur. Die Schicht entlang der Punkte erscheint hier gestreckt.",
    title: (mm) => `Gekrümmte Schicht, ${fixed(mm, 1)} mm lang`,
    canvas:
      "Schicht entlang der Kurve. Die Pfeiltasten gehen ein Pixel entlang der Kurve oder quer dazu, und das Fadenkreuz folgt. Mit der Umschalttaste gehen sie zehn Pixel. Strg mit einer Pfeiltaste verschiebt das Bild. Plus und Minus zoomen. Komma und Punkt drehen die Schicht um die Kurve. Die Rücktaste entfernt den letzten Punkt. R zeigt die ganze Schicht.",
    position: (along, across) => `${fixed(along, 1)} mm entlang, ${signed(fixed(across, 1))} mm quer`,
    angleName: "Winkel um die Kurve",
    angle: (degrees) => `Winkel ${degrees}°`,
    angleHelp: "Dreht die Schicht um die Kurve.",
    height: "Höhe, mm",
    heightHelp: "Die Größe der gekrümmten Schicht quer zur Kurve in mm.",
    undo: "Letzten Punkt der Kurve entfernen",
    clear: "Kurve löschen",
    full: "Die Kurve hat die Höchstzahl von 64 Punkten.",
    noMeasures: "Das Strecken verzerrt, was neben der Kurve liegt. Messen Sie deshalb in den anderen Schichten.",
  },
  scale: (length) => `Maßstab: ${length}`,
  millimetres: (mm) => `${String(mm).replace(".", ",")} mm`,
  centimetres: (cm) => `${cm} cm`,
  display: "Darstellung",
  smooth: "Weich",
  smoothHelp:
    "Zeigt weiche Übergänge zwischen den gespeicherten Werten. Schalten Sie das aus, um jeden gespeicherten Wert als scharfes Rechteck zu sehen. Angezeigte Werte und Messungen sind die gespeicherten, in gekippten oder dicken Schichten Werte dazwischen.",
  overlay: "Farben",
  overlayHelp: "Zeigt die Farben des 3D-Bildes über den grauen Schichten.",
  overlayStrength: "Stärke der Farben",
  labels: "Strukturen",
  labelsHelp:
    "Zeigt die Strukturen der Liste „Strukturen“ in ihren Farben über den Schichten. In einer dicken Schicht hat jedes Pixel die Struktur, die dort am häufigsten ist.",
  labelsStrength: "Stärke der Strukturen",
  said: (title, value, place) => `${title}, ${value}, ${place}`,
  unsupported:
    "Dieser Browser ist zu alt, um die Schichten zu zeigen. Aktualisieren Sie ihn, oder verwenden Sie einen anderen Browser.",
  damaged: "Eine Schicht wurde bei der Übertragung beschädigt. Laden Sie die Seite neu, um sie noch einmal zu laden.",
};
