import { number } from "./counting";

/** The user's account page. */
export const myAccount = {
  room: "Your storage and rendering time",
  storage: "Storage",
  storageUsed: (used: string, all: string) => `${used} of ${all}`,
  time: "Rendering time this month",
  timeUsed: (used: string, all: string) => `${used} of ${all}`,
  timeHelp: (date: string) =>
    `Rendering time is the time that our servers spend on your pictures. Finished pictures use none. Your rendering time resets on ${date}.`,
  timeSpent: (date: string) => `You have used up your rendering time for this month. It resets on ${date}.`,
  hours: (ms: number) => {
    const minutes = ms / 60_000;
    return minutes < 1
      ? `${Math.round(ms / 1000)} s`
      : minutes < 120
        ? `${Math.round(minutes)} min`
        : `${number.format(Math.round(minutes / 6) / 10)} h`;
  },
  address: "Your email address",
  addressNow: (email: string) => `You sign in with ${email}.`,
  newAddress: "New email address",
  changeAddress: "Change email address",
  addressSent: (email: string) =>
    `We’ve sent a link to ${email}. Open it to confirm the new address. Nothing changes until then.`,
  password: "Your password",
  current: "Current password",
  changePassword: "Change password",
  passwordChanged: "Your password has been changed. All other browsers have been signed out.",
  browsers: "Where you’re signed in",
  browsersHelp:
    "For each sign-in, we store the time and roughly which browser you used, but not your location or IP address.",
  aBrowser: "Unknown browser",
  thisOne: "this browser",
  since: (when: string) => `since ${when}`,
  used: (when: string) => `last used ${when}`,
  endOne: "Sign out",
  endOneOf: (browser: string) => `Sign out ${browser}`,
  endAll: "Sign out everywhere",
  data: "Your data",
  exportHelp:
    "You can download a file with all the data we store about you: your account, your scans as 3D image data, your presets and recordings, and a log of what was done with them. Only you can download the file. We delete it after one day.",
  exportAsk: "Create the file",
  exportQueued: "The file is being created…",
  exportWaiting:
    "The server doesn’t have room for the file at the moment. It will be created as soon as there is room. You don’t have to wait on this page.",
  exportReady: (size: string) => `The file is ready: ${size}.`,
  exportUntil: (when: string) => `You can download it until ${when}.`,
  exportFailed: "The file couldn’t be created. Try again.",
  exportGet: "Download",
  exportDelete: "Delete the file",
  remove: "Delete account",
  removeHelp:
    "Deleting your account also deletes your scans, pictures, presets and recordings, and ends all sharing. It happens immediately and can’t be undone.",
  removeAsk: "Delete my account…",
  removeTitle: "Delete your account?",
  removeText:
    "This will permanently delete your account and all your scans. Open pictures will be closed, and links will stop working. This can’t be undone. Enter your password to confirm.",
  removeYes: "Delete account",
  removed: "Your account and all its data have been deleted.",
} as const;
