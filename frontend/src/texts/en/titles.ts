/** Page titles, used as the heading and in the browser tab. */
export const titles = {
  signUp: "Create your account",
  signIn: "Sign in to Diaphane",
  code: "Enter your code",
  verify: "Choose your password",
  checkMail: "Check your email",
  forgot: "Reset your password",
  reset: "Choose a new password",
  resetDone: "Password changed",
  confirmEmail: "Your new email address",
  account: "Your account",
  admin: "Administration",
  scans: "My scans",
  add: "Add a scan",
  view: "Viewer",
  notFound: "Page not found",
  incompleteLink: "This link is incomplete",
} as const;
