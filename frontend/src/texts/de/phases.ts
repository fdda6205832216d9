import type { Texts } from "../shape";
import { fixed, number } from "./counting";

const milliseconds = (value: number) => `${number.format(Math.round(value * 10) / 10)} ms`;

export const phases: Texts["phases"] = {
  title: "Phasen der Aufnahme",
  play: "Phasen abspielen (K)",
  pause: "Anhalten (K)",
  choose: "Phase",
  rate: "Phasen pro Sekunde",
  perSecond: (rate: number) => `${rate}/s`,
  repeat: "Wiederholen",
  labels: {
    index: (phase: number, count: number) => `${phase + 1} von ${count}`,
    time: (value: number) => (value < 10_000 ? milliseconds(value) : `${fixed(value / 1000, 1)} s`),
    cycle: (percent: number) => `${number.format(Math.round(percent))} %`,
    echo: (value: number) => `Echo ${milliseconds(value)}`,
    bValue: (value: number) => `b = ${Math.round(value)} s/mm²`,
  },
  loading: (loaded: number, count: number) => `Phasen werden geladen: ${loaded} von ${count}`,
  tooMany: "Es passen nicht alle Phasen in den Speicher des Renderers. Sie laufen deshalb langsamer.",
  helpRows: [
    ["Phasen abspielen oder anhalten", "Taste unter dem Bild", "Taste unter dem Bild", "K"],
    ["Nächste oder vorige Phase", "Regler unter dem Bild", "Regler unter dem Bild", "Punkt, Komma"],
  ],
  cycles: "Wie oft die Phasen abgespielt werden",
  cyclesHint: "0: Das Video zeigt nur die jetzige Phase.",
  wrongCycles: (least: number, most: number) =>
    `Geben Sie eine ganze Zahl zwischen ${least} und ${number.format(most)} ein.`,
};
