import type { Trouble } from "../../protocol/connection";
import { count, number } from "./counting";

const troubles: Record<Trouble, string> = {
  lost: "Connection lost. Reconnecting…",
  worker_lost: "The rendering server stopped. Reconnecting…",
  no_worker: "No rendering server is free right now. Trying again…",
  guests_full: "All places for guests are taken at the moment. Trying again…",
  unreachable: "We can’t reach Diaphane. Trying again…",
  refused: "Something went wrong. Trying again…",
  not_ready: "This scan is still being prepared. Its picture will appear automatically.",
  not_found: "This scan doesn’t exist, or you don’t have access to it.",
  signed_out: "You are signed out. Sign in again to continue.",
  taken_over: "This picture is now open in another window.",
  time_spent: "You have used up your rendering time for this month.",
  link_ended: "This link has expired or was disabled. Ask the person who shared it for a new one.",
  displaced:
    "Diaphane is busy, and people with an account have priority. Sign in, or reload this page in a few minutes.",
};

/** The viewer. */
export const viewer = {
  lostEnvironment: "The environment of this view no longer exists. An even light takes its place.",
  back: "My scans",
  /** `looks` is the number of looks to choose from. */
  stage: (looks: number) =>
    `3D view of the scan. Arrow keys rotate, plus and minus zoom, R resets the view, ${looks > 1 ? `1 to ${looks} choose a look, ` : ""}and the question mark shows all keys.`,
  first: "Preparing the picture…",
  troubles,
  /** Shown if a change brings no new picture for some seconds. */
  late: "The rendering server isn’t answering.",
  /** Added to a trouble while the last picture is still shown. */
  meanwhile: "Until then, the picture stays as it is.",
  continueHere: "Continue here",
  treatment: {
    tableHidden: "The table, headrest or frame is hidden.",
    showTable: "Show it",
    close: "Close this note",
    interpolated: (between: number) =>
      `The slices of this scan are far apart, so the picture shows ${between === 1 ? "a computed slice" : `${between} computed slices`} between each pair of neighbouring slices.`,
  },
  pictureTime: {
    soon: (minutes: number) =>
      `You have ${minutes > 1 ? `about ${count(minutes, "minute", "minutes")}` : "less than a minute"} of rendering time left this month. Finished pictures use no rendering time.`,
    ending: (at: string, reset: string) =>
      `You have used up your rendering time for this month. This picture stays open until ${at}. Your rendering time resets on ${reset}.`,
    over: "No rendering time left",
    overText: (reset: string) =>
      `You have used up your rendering time for this month. It resets on ${reset}. Your scans are still there, and nothing is lost.`,
    overBefore: "You have used up your rendering time for this month. Your scans are still there, and nothing is lost.",
    more: "Your administrator can raise your limit.",
    hide: "Hide this message",
    account: "See your usage",
  },
  notMedical: "Not a medical device. Not for diagnosis.",
  visitor: {
    back: "Back",
    invite: "Create account",
    over: "Your visit has ended",
    overText: {
      sample: "You can view a sample for 20 minutes at a time, so that others get their turn.",
      link: "The time for this visit is over, or the link has expired or was disabled. If it doesn’t open again, ask the person who shared it for a new one.",
      session: "This link has expired or was disabled. Ask the person who shared it for a new one.",
    },
    inviteText: "With an account of your own, you can view your own scans for as long as you like.",
    again: "View it again",
    toSamples: "Back to the samples",
  },
  hints: {
    title: (n: number, all: number) => `Tip ${n} of ${all}`,
    all: [
      "Drag the picture to turn it. Pinch, or use the mouse wheel, to zoom.",
      "The pictures at the bottom show other looks of the same scan.",
      "Light, lens and cuts are in the menu on the left. You can undo any change.",
    ] as readonly string[],
    /** Takes the place of the first tip on touch screens. */
    touch: "Drag the picture with one finger to turn it. Pinch to zoom.",
    next: "Next",
    done: "Got it",
    hide: "Hide the tips",
  },
  presets: "Looks",
  /** Names of the built-in looks. Only CT values distinguish skin, muscle, bone and air. */
  lookOfCt: {
    skin: "Skin",
    muscle: "Muscle",
    vessels: "Vessels",
    bone: "Bone",
    through: "Glass",
    dense: "Teeth",
    airways: "Airways",
  } as Readonly<Record<string, string>>,
  lookOfOther: {
    brain: "Brain",
    through: "Glass",
    skin: "Surface",
    muscle: "Soft tissue",
    vessels: "Brightest parts",
    bone: "Bright parts",
    airways: "See-through",
  } as Readonly<Record<string, string>>,
  reset: "Reset the view",
  fullscreen: "Full screen",
  screenshot: "Save or share",
  help: "Controls",
  quality: "Quality",
  qualityOpen: "Show the quality",
  details: "Details",
  samples: "Samples",
  error: "Noise level",
  errorUnknown: "measuring…",
  errorHelp:
    "How far, on average, the picture may still be from the finished one. Four times as many samples halve the noise level.",
  time: "Time",
  perSecond: (n: number) => `${n < 10 ? n.toFixed(1) : number.format(Math.round(n))} per second`,
  plot: "Noise level over time, both axes logarithmic",
  finished: "Finished",
  lossless: (samples: number) => `Lossless, ${count(samples, "sample", "samples")}`,
  losslessHelp:
    "Every pixel is exactly as the renderer computed it. This browser has checked that nothing was lost in transit.",
  tileDamaged: "The final picture was corrupted in transit. The streamed picture is shown instead.",
  refining: (part: number | null) => (part === null ? "Sharpening…" : `Sharpening… ${Math.floor(100 * part)}%`),
  smoothedHelp:
    "This picture is denoised because it would still look grainy otherwise. The finished picture is never denoised.",
  seconds: (s: number) =>
    s < 1 ? `${(s * 1000).toFixed(0)} ms` : s < 100 ? `${s.toFixed(1)} s` : `${(s / 60).toFixed(1)} min`,
  percent: (error: number) => `${(100 * error).toPrecision(2)}%`,
  orientation: (side: string) => `Viewed from ${side}`,
  viewFrom: (side: string) => `View from ${side}`,
  sides: {
    L: "the patient’s left",
    R: "the patient’s right",
    A: "the front",
    P: "the back",
    S: "above",
    I: "below",
  } as Readonly<Record<string, string>>,
  noCodec: "This browser can’t show the pictures. Update it, or use another browser.",
  helpRows: (looks: number): readonly (readonly [string, string, string, string])[] => [
    ["Rotate", "Drag with the left button", "Drag with one finger", "Arrow keys"],
    ["Move", "Drag with the middle button, or Shift + drag", "Drag with two fingers", "Shift + arrow keys"],
    ["Zoom", "Wheel, or drag with the right button", "Pinch", "+ and −"],
    ["Roll", "Ctrl + drag", "", "Ctrl + ← →"],
    ["Look from a side", "Press the cube", "Press the cube", "Shift + A, P, L, R, S or I, as on the cube"],
    ["Show me around", "“Views” on the left", "“Views” on the left", "T, then P to pause and Esc to stop"],
    ["Reset the view", "Button at the top", "Button at the top", "R"],
    ...(looks > 1
      ? [["Choose a look", "Pictures at the bottom", "Pictures at the bottom", `1 to ${looks}`] as const]
      : []),
    ["Undo", "Menu on the left", "Menu on the left", "Ctrl + Z"],
    ["Redo", "Menu on the left", "Menu on the left", "Ctrl + Shift + Z"],
    ["Show the slices", "Button at the top", "Button at the top", "V"],
    ["Measure in a slice", "Ruler, angle or ellipse, then drag", "Ruler, angle or ellipse, then drag", "Enter"],
    ["Smooth or coloured slices", "“Smooth” and “Colours” above them", "“Smooth” and “Colours” above them", "Space"],
    ["Full screen", "Button at the top", "", "F"],
    ["Save or share", "Button at the top", "Button at the top", "S"],
  ],
  helpButtons: { title: "Buttons", slices: "Show the slices" },
  helpHeads: ["Action", "Mouse", "Touch", "Keyboard"] as const,
} as const;
