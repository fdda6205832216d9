import type { Texts } from "../shape";

export const curve: Texts["curve"] = {
  save: "Kurve speichern",
  saveAs: (format) => `Kurve als ${format} speichern`,
  timeAxis: "Rechenzeit in s",
  samplesAxis: "Samples pro Bildpunkt",
  errorAxis: "Rauschen (relativer Fehler)",
  guide: "Steigung −1/2: Der Fehler sinkt mit der Wurzel der Zeit.",
  file: {
    title: "Fehler des Bildes über der Rechenzeit",
    samples: "samples: Samples pro Bildpunkt.",
    seconds:
      "seconds: Rechenzeit in Sekunden seit der letzten Änderung der Ansicht, einschließlich der Vorbereitung der Szene.",
    error:
      "error: geschätzter quadratischer Mittelwert des Unterschieds zwischen diesem Bild und dem fertigen. 1 ist der Abstand von Schwarz zu Weiß auf dem Bildschirm, 0.05 sind also 5 %.",
    guide: "Bei einem Pathtracer sinkt der Fehler mit der Wurzel der Zeit: Steigung -1/2 bei logarithmischen Achsen.",
    source: (width, height, device) => `${width} × ${height} Bildpunkte, berechnet auf ${device}`,
  },
};
