/** What every page shares: the frame, its links, the words of buttons. */
export const common = {
  name: "Diaphane",
  tagline: "See your own scan, as it is.",
  skip: "Skip to the content",
  theme: { to_dark: "Use the dark look", to_light: "Use the light look" },
  nav: { scans: "My scans", add: "Add a scan", admin: "Administration", account: "Your account", sign_out: "Sign out", signed_in_as: (email: string) => `Signed in as ${email}` },
  language: "Language",
  close: "Close",
  cancel: "Cancel",
  try_again: "Try again",
  loading: "Loading…",
  not_found: "This page does not exist.",
  to_start: "Go to the start",
} as const;
