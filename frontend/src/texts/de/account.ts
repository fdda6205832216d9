import type { Texts } from "../shape";

export const account: Texts["account"] = {
  email: "E-Mail-Adresse",
  password: "Passwort",
  passwordHint: "Mindestens 12 Zeichen. Gut geeignet sind einige Wörter hintereinander.",
  passwordShort: "Verwenden Sie mindestens 12 Zeichen.",
  passwordMissing: (missing) =>
    missing === 1 ? "Es fehlt noch 1 Zeichen." : `Es fehlen noch ${missing.toFixed(0)} Zeichen.`,
  passwordLevels: ["Zu viele Wiederholungen.", "Lang genug, aber länger ist besser.", "Gut.", "Sehr gut."],
  emailWrong: "Geben Sie eine E-Mail-Adresse im Format name@example.com ein.",
  required: "Bitte füllen Sie dieses Feld aus.",
  show: "Passwort anzeigen",
  hide: "Passwort verbergen",
  signUp: "Konto erstellen",
  signIn: "Anmelden",
  haveOne: "Sie haben schon ein Konto?",
  haveNone: "Neu hier?",
  signUpLead:
    "Machen Sie aus dem CT oder MRT auf Ihrer CD ein 3D-Bild, das Sie von allen Seiten betrachten können. Nur Sie sehen es, solange Sie es nicht teilen.",
  signInLead: "Diaphane macht aus einer CT- oder MRT-Aufnahme ein 3D-Bild, das Sie von allen Seiten betrachten können.",
  samples: "Beispielaufnahme ohne Konto ansehen",
  mailSent: (email) =>
    `Wir haben eine E-Mail an ${email} geschickt. Öffnen Sie den Link darin, um Ihre Adresse zu bestätigen und ein Passwort zu wählen.`,
  mailHint: "Nichts angekommen? Es kann eine Minute dauern. Sehen Sie auch im Spam-Ordner nach.",
  mailAgain: "Adresse ändern oder noch einmal senden",
  toSignIn: "Zur Anmeldung",
  verifyLead:
    "Damit bestätigen Sie Ihre E-Mail-Adresse. Wenn Sie kein Konto bei Diaphane angelegt haben, schließen Sie diese Seite einfach.",
  verifySubmit: "Passwort festlegen und anmelden",
  verified: (email: string) =>
    `Ihre Adresse ist bestätigt und Ihr Passwort festgelegt. Sie sind als ${email} angemeldet.`,
  verifiedTitle: "Willkommen",
  verifyNoToken:
    "Dieser Link ist unvollständig. Öffnen Sie den Link in der E-Mail noch einmal, oder kopieren Sie ihn ganz.",
  verifyFailed: "Ihre Adresse konnte nicht bestätigt werden",
  forgot: "Passwort vergessen?",
  forgotLead:
    "Geben Sie Ihre E-Mail-Adresse ein. Wir schicken Ihnen einen Link, über den Sie ein neues Passwort festlegen können.",
  forgotSend: "Link senden",
  forgotSent: (email) =>
    `Falls es zu ${email} ein Konto gibt, haben wir einen Link dorthin geschickt. Er gilt eine Stunde.`,
  resetLead: "Sobald das neue Passwort festgelegt ist, werden Sie überall abgemeldet.",
  reset: "Neues Passwort festlegen",
  resetDone:
    "Ihr Passwort wurde geändert, und Sie wurden überall abgemeldet. Melden Sie sich jetzt mit dem neuen Passwort an.",
  newPassword: "Neues Passwort",
  confirmingEmail: "Ihre neue Adresse wird bestätigt …",
  emailChanged: "Ihr Konto hat jetzt diese Adresse. Melden Sie sich künftig damit an.",
  askAgain: "Neuen Link anfordern",
  art: "Schichten einer Aufnahme, eine über der anderen",
};
