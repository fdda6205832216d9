/** Texts that every page shares: navigation and common buttons. */
export const common = {
  name: "Diaphane",
  tagline: "See your own scan in 3D.",
  skip: "Skip to main content",
  theme: { toDark: "Switch to dark mode", toLight: "Switch to light mode" },
  nav: {
    scans: "My scans",
    add: "Add a scan",
    admin: "Administration",
    account: "Your account",
    signOut: "Sign out",
    signed_in_as: (email: string) => `Signed in as ${email}`,
  },
  language: "Language",
  close: "Close",
  cancel: "Cancel",
  tryAgain: "Try again",
  loading: "Loading…",
  loadingSlow: "Still loading. The server is slow to answer at the moment; nothing is lost.",
  notFound: "This page doesn’t exist. Check the address, or go to the start page.",
  incompleteLink: "Part of it is missing. Copy the whole link, up to its last character, or ask for it again.",
  toStart: "Go to the start page",
} as const;
