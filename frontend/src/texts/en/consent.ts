/** The consent to the processing of health data, at sign-up and when the privacy notice has changed. */
export const consent = {
  title: "We need your consent",
  lead: "Scans are health data. We may process them only if you agree. Our privacy notice is new, or it has changed since you last agreed. Please read it before you continue.",
  agree: "I agree that this service processes my scans, which are health data, as its privacy notice describes.",
  notice: "Read the privacy notice (opens in a new tab)",
  missing: "Tick this box to continue.",
  go: "Continue",
  otherwise:
    "If you don’t agree, you can sign out. You can also download or delete your data on the page “Your account”.",
} as const;
