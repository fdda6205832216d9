import type { Texts } from "../shape";

export const secondFactor: Texts["secondFactor"] = {
  title: "Zwei-Faktor-Authentifizierung",
  about:
    "Mit der Zwei-Faktor-Authentifizierung melden Sie sich mit Ihrem Passwort und mit einem Code aus einer App auf Ihrem Telefon an (jede TOTP-Authenticator-App eignet sich). Ein gestohlenes Passwort allein genügt dann nicht mehr.",
  required:
    "Sie haben Administratorrechte. Richten Sie die Zwei-Faktor-Authentifizierung ein, um die Verwaltungsseiten zu nutzen.",
  toAccount: "In Ihrem Konto einrichten",
  begin: "Einrichten",
  scan: "Scannen Sie diesen QR-Code mit der Authenticator-App auf Ihrem Telefon.",
  qr: "QR-Code für eine Authenticator-App. Er enthält denselben Schlüssel wie der Text darunter.",
  orType: "Oder geben Sie diesen Schlüssel in der App ein:",
  confirm: "Aktivieren",
  code: "Authentifizierungscode",
  codeHint: "Die sechs Ziffern, die Ihre App anzeigt. Sie wechseln alle 30 Sekunden.",
  recoveryCode: "Ersatzcode",
  recoveryCodeHint: "Einer der zehn Codes, die Sie aufbewahrt haben. Jeder gilt nur einmal.",
  recoveryTitle: "Ihre Ersatzcodes",
  recoveryText:
    "Ab jetzt brauchen Sie zum Anmelden einen Code. Bewahren Sie diese Ersatzcodes dort auf, wo Sie sie auch ohne Ihr Telefon finden. Jeden können Sie einmal anstelle eines Authentifizierungscodes verwenden. Sie werden nicht noch einmal angezeigt.",
  copy: "Codes kopieren",
  copied: "Kopiert.",
  copyFailed: "Die Codes konnten nicht kopiert werden. Markieren Sie sie und kopieren Sie sie selbst.",
  kept: "Ich habe sie gespeichert",
  setUpSince: (day) => `Aktiv seit ${day}.`,
  codesLeft: (left) => (left === 1 ? "Sie haben noch 1 Ersatzcode." : `Sie haben noch ${left.toFixed(0)} Ersatzcodes.`),
  renew: "Neue Ersatzcodes erstellen …",
  remove: "Deaktivieren …",
  removeRequired:
    "Sie haben Administratorrechte. Ohne Zwei-Faktor-Authentifizierung können Sie die Verwaltungsseiten nicht nutzen.",
  ask: {
    renew: {
      title: "Neue Ersatzcodes erstellen?",
      text: "Ihre alten Codes gelten dann nicht mehr. Bestätigen Sie mit Ihrem Passwort und einem Authentifizierungscode.",
      yes: "Neue Codes erstellen",
    },
    remove: {
      title: "Zwei-Faktor-Authentifizierung deaktivieren?",
      text: "Zum Anmelden genügt dann Ihr Passwort allein. Bestätigen Sie mit Ihrem Passwort und einem Authentifizierungscode oder Ersatzcode.",
      yes: "Deaktivieren",
    },
  },
  signInLead: "Ihr Passwort stimmt. Es fehlt nur noch ein Schritt.",
  useRecovery: "Ersatzcode verwenden",
  useDevice: "Code aus meiner App verwenden",
  back: "Zurück",
};
