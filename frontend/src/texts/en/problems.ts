/** Connection and server errors that can occur on any page. */
export const problems = {
  offline: "We couldn’t reach Diaphane. Check your connection and try again.",
  unreachable: "We can’t reach Diaphane. Trying again…",
  busy: "Diaphane is busy at the moment. Try again shortly.",
  outcomeUnknown:
    "The connection was lost while your change was being saved. Reload the page to see whether it was saved.",
  internal: "Something went wrong on our side. Try again in a moment.",
  wrongCredentials: "The email address or password is wrong. Check both and try again.",
  disabled: "An administrator has disabled this account. Contact the people who run this Diaphane server.",
  tooMany: "Too many attempts. Wait a while, then try again.",
  linkExpired: "This link has expired or has already been used. Request a new one.",
} as const;
