/** The titles of pages: the heading, and what the browser shows in its tab. */
export const titles = {
  sign_up: "Create your account",
  sign_in: "Sign in",
  code: "Your code",
  verify: "Choose your password",
  check_mail: "Check your mail",
  forgot: "A new password",
  reset: "Choose a new password",
  confirm_email: "Your new address",
  account: "Your account",
  admin: "Administration",
  scans: "My scans",
  add: "Add a scan",
  view: "Viewer",
  not_found: "Nothing here",
} as const;
