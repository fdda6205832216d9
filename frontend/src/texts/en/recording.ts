import { count } from "./counting";

/** Recording how somebody looks at pictures. */
export const recording = {
  open: "Recording",
  title: "Record how I look at pictures",
  lead: "It helps to make Diaphane quicker for the way people really use it. Recorded is how you turn a picture and choose its look, and when: not your name, not which scan, no picture. Recordings are deleted after 90 days, and whenever you like.",
  consent: "Record how I look at pictures",
  item: (seconds: number, steps: number) => `${seconds < 60 ? `${seconds.toFixed(0)} s` : `${(seconds / 60).toFixed(1)} min`}, ${count(steps, "step", "steps")}`,
  export_one: "Export",
  delete_one: "Delete",
} as const;
