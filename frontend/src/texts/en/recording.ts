import { count } from "./counting";

/** Usage recording: how a user moves the view and changes the look. */
export const recording = {
  open: "Usage recording",
  title: "Usage recording",
  lead: "This helps us make Diaphane faster for the way people really use it. We record how and when you rotate the view and change its look. We don’t record your name, which scan you view, or any picture. Recordings are deleted after 90 days, and you can delete them at any time.",
  consent: "Record how I use the viewer",
  item: (seconds: number, steps: number) =>
    `${seconds < 60 ? `${seconds.toFixed(0)} s` : `${(seconds / 60).toFixed(1)} min`}, ${count(steps, "step", "steps")}`,
  exportOne: "Download",
  deleteOne: "Delete",
} as const;
