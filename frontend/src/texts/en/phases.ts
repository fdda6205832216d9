import { fixed, number } from "./counting";

const milliseconds = (value: number) => `${number.format(Math.round(value * 10) / 10)} ms`;

/** Scans with several phases, echoes or b-values. */
export const phases = {
  title: "Phases of the scan",
  play: "Play the phases (K)",
  pause: "Pause (K)",
  choose: "Phase",
  rate: "Phases per second",
  perSecond: (rate: number) => `${rate}/s`,
  repeat: "Repeat",
  /** Labels of one phase, by what distinguishes the phases. */
  labels: {
    index: (phase: number, count: number) => `${phase + 1} of ${count}`,
    time: (value: number) => (value < 10_000 ? milliseconds(value) : `${fixed(value / 1000, 1)} s`),
    cycle: (percent: number) => `${number.format(Math.round(percent))} %`,
    echo: (value: number) => `Echo ${milliseconds(value)}`,
    bValue: (value: number) => `b = ${Math.round(value)} s/mm²`,
  },
  loading: (loaded: number, count: number) => `Loading phases: ${loaded} of ${count}`,
  tooMany: "The phases don’t all fit in the renderer’s memory, so they play more slowly.",
  helpRows: [
    ["Play or pause the phases", "Play button below the picture", "Play button below the picture", "K"],
    ["Next or previous phase", "Slider below the picture", "Slider below the picture", "Full stop, comma"],
  ] as const,
  cycles: "How often the phases are played",
  cyclesHint: "0: the video shows the current phase only.",
  wrongCycles: (least: number, most: number) => `Enter a whole number between ${least} and ${number.format(most)}.`,
} as const;
