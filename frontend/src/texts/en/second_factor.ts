/** Two-factor authentication: setup, sign-in and recovery codes. */
export const secondFactor = {
  title: "Two-factor authentication",
  about:
    "With two-factor authentication, you sign in with your password and a code from an app on your phone (any TOTP authenticator app). A stolen password alone won’t be enough to sign in.",
  required: "You are an administrator. Set up two-factor authentication to use administrator features.",
  toAccount: "Set it up in your account",
  begin: "Set up",
  scan: "Scan this QR code with the authenticator app on your phone.",
  qr: "QR code for an authenticator app. It contains the same key as the text below.",
  orType: "Or enter this key in the app:",
  confirm: "Turn on",
  code: "Authentication code",
  codeHint: "The six digits that your app shows. They change every 30 seconds.",
  recoveryCode: "Recovery code",
  recoveryCodeHint: "One of the ten codes that you saved. Each code works once.",
  recoveryTitle: "Your recovery codes",
  recoveryText:
    "From now on, signing in requires a code. Keep these recovery codes where you can find them without your phone. You can use each one once instead of an authentication code. They won’t be shown again.",
  copy: "Copy the codes",
  copied: "Copied.",
  copyFailed: "The codes couldn’t be copied. Select them and copy them yourself.",
  kept: "I’ve saved them",
  setUpSince: (day: string) => `Active since ${day}.`,
  codesLeft: (left: number) =>
    left === 1 ? "You have 1 recovery code left." : `You have ${left.toFixed(0)} recovery codes left.`,
  renew: "Generate new recovery codes…",
  remove: "Turn off…",
  removeRequired: "You are an administrator. Without two-factor authentication, you can’t use administrator features.",
  ask: {
    renew: {
      title: "Generate new recovery codes?",
      text: "Your old codes will stop working. Confirm with your password and an authentication code.",
      yes: "Generate new codes",
    },
    remove: {
      title: "Turn off two-factor authentication?",
      text: "Your password alone will then be enough to sign in. Confirm with your password and an authentication code or a recovery code.",
      yes: "Turn off",
    },
  },
  signInLead: "Your password is correct. There is one more step.",
  useRecovery: "Use a recovery code",
  useDevice: "Use a code from my app",
  back: "Back",
} as const;
