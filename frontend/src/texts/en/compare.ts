import { number } from "./counting";

const mm = (n: number): string => (n < 10 ? n.toFixed(1) : number.format(Math.round(n)));

/** Two scans side by side, or one over the other. */
export const compare = {
  open: "Compare with another scan",
  openOf: (title: string) => `Compare ${title} with another scan`,
  choose: "Choose the second scan",
  chooseLead: (title: string) => `We show it next to “${title}”, or over it.`,
  none: "There is no second scan to compare with. Add one first.",
  title: (first: string, second: string) => `${first} and ${second}`,
  ways: "Ways to compare",
  modes: { side: "Side by side", over: "One over the other" },
  link: "Linked cameras",
  links: { off: "Turn separately", sides: "Turn together", places: "Same place in both" },
  linksShort: { off: "Separately", sides: "Together", places: "Same place" },
  swap: "Swap the scans",
  help: "Turn one picture, and the other turns with it. A look that both scans have changes in both.",
  alone: (title: string) => `Open ${title} alone`,
  looksOf: (title: string) => `Looks of ${title}`,
  align: {
    open: "Align",
    title: "Align the scans",
    shared: "Both scans share a frame of reference, so every place lies at the same position in both.",
    needed:
      "These scans don’t share a frame of reference: they come from different examinations, so the same place lies at different positions. Diaphane can turn and shift the second scan until both match.",
    duration: "This usually takes less than a few minutes.",
    start: "Align them",
    waiting: "Waiting for its turn…",
    running: "Aligning the scans…",
    leave: "You can leave this page. The result is kept.",
    ready: (residual: number) =>
      `The scans are aligned to ${residual < 0.1 ? "less than 0.1" : `about ${mm(residual)}`} mm, as far as their images show. Where the body has moved or changed in between, places lie farther apart.`,
    overlap: (part: number) => `${Math.round(100 * part)}% of the smaller scan lies inside the other.`,
    notMedical: "Not for diagnosis. Check that known places match before you rely on it.",
    again: "Align again",
    remove: "Discard the alignment",
    failed: "The scans couldn’t be aligned.",
    reasons: {
      little_overlap: "They hardly show the same part of the body.",
      not_converged: "No position was found in which they match well enough.",
      no_structure: "One of them shows too little.",
      no_memory: "The server has too little memory for scans of this size.",
      too_slow: "It took too long.",
    } as Readonly<Record<string, string>>,
    notYours: "Only the owner of one of the two scans can align them.",
    show: "Show both",
  },
  overlay: {
    title: "Second scan",
    share: "Mixture",
    shareText: (share: number) => `${Math.round(100 * share)}% second scan`,
    first: "First",
    second: "Second",
    look: "Look",
    looks: { hot: "Hot metal", bone: "Bone", tint: "Tinted", same: "Like the first" } as Readonly<
      Record<string, string>
    >,
    mode: "Show",
    modes: { mixed: "Both mixed", split: "Before and after" },
    alignment: "Alignment",
    divider: "Divider between the first and the second scan",
    dividerText: (split: number) => `${Math.round(100 * split)}% from the left`,
    unavailable: "This server can’t show one scan over another.",
  },
} as const;
