/** What went wrong on the way to the server. */
export const problems = {
  offline: "Diaphane cannot be reached. Check your connection and try again.",
  unreachable: "Diaphane cannot be reached. Trying again…",
  busy: "Diaphane is busy. Try again in a moment.",
  outcome_unknown: "The connection was lost while your change was being saved. Reload the page to see whether it was saved.",
  internal: "Something went wrong on our side. Try again in a moment.",
  wrong_credentials: "This address and password do not belong together.",
  disabled: "An administrator has switched this account off. Write to whoever runs this Diaphane.",
  too_many: "Too many attempts. Wait a little and try again.",
  link_expired: "This link has been used already or is too old. Ask for a new one.",
} as const;
