/** Connection and server errors that can occur on any page. */
export const problems = {
  unreachable: "We can’t reach Diaphane. Trying again…",
  internal: "Something went wrong on our side. Try again in a moment.",
  notTaken: "The server didn’t accept this change. Reload the page and try again.",
  /** Shown instead of the server’s own sentence, by kind of problem. */
  always: {
    offline: "We couldn’t reach Diaphane. Check your connection and try again.",
    "wrong-credentials": "The email address or password is wrong. Check both and try again.",
    "code-needed":
      "Two-factor authentication was turned on in another window. Reload the page, then enter a code as well.",
    disabled: "An administrator has disabled this account. Contact the administrator of this Diaphane server.",
    "link-expired": "This link has expired or has already been used. Request a new one.",
    busy: "Diaphane is busy at the moment. Try again shortly.",
    unavailable: "Diaphane is busy at the moment. Try again shortly.",
    "outcome-unknown":
      "The connection was lost while your change was being saved. Reload the page to see whether it was saved.",
    internal: "Something went wrong on our side. Try again in a moment.",
  },
  /** Like `kinds`, by the field with the error. */
  fields: {
    email: "Enter a valid email address.",
    password: "Check the password.",
    current: "The password is incorrect.",
    code: "This code is incorrect or was already used. Wait for the next one.",
  },
  /** Shown if the server’s sentence is missing or in another language, by kind of problem. */
  kinds: {
    invalid: "Check what you have entered.",
    unauthenticated: "You are signed out. Sign in again.",
    "wrong-code": "This code is incorrect or was already used. Wait for the next one.",
    forbidden: "You don’t have permission to do this.",
    "consent-needed": "The privacy notice has changed. Reload the page and read it.",
    "second-factor-required": "Set up two-factor authentication first.",
    "not-found": "This no longer exists, or you don’t have access to it.",
    conflict: "This isn’t possible at the moment. Reload the page and try again.",
    "not-ready": "This scan is still being prepared. Try again shortly.",
    "not-aligned": "These scans don’t share a frame of reference. Align them first.",
    "not-anonymised": "First cut away anything that could identify the person.",
    precondition: "This was changed in another window. Reload the page and try again.",
    "over-quota": "You don’t have enough storage left. Delete a scan first.",
    "too-many-data-sets": "You have as many scans as an account can hold. Delete one first.",
    "render-time-spent": "You have used up your rendering time for this month.",
    "upload-too-large": "This scan is larger than the server accepts.",
    "body-too-large": "This is larger than the server accepts.",
    "storage-full": "The server has run out of space. Try again later.",
    "too-many": "Too many attempts. Wait a while, then try again.",
    "too-many-attempts": "Too many attempts. Wait a while, then try again.",
    "no-worker": "No rendering server is free right now. Try again shortly.",
    "archive-unreachable": "The archive doesn’t respond. Try again later, or ask your administrator.",
    "archive-refused": "The archive doesn’t let Diaphane in. Ask your administrator to check the credentials.",
    "archive-faulty": "The archive sent something that isn’t valid. Ask your administrator.",
  },
} as const;
