import type { Texts } from "..";
import type { Soon } from "../shape";

export const second_factor: Soon<Texts["second_factor"]> = {
  title: "Zweiter Faktor",
  about: "Mit einem zweiten Faktor werden Sie beim Anmelden nach Ihrem Passwort und nach einem Code gefragt, den eine App auf Ihrem Telefon zeigt (jede App für zeitabhängige Einmalcodes). Wer nur Ihr Passwort kennt, kommt nicht hinein.",
  required: "Sie gehören zur Verwaltung. Deren Seiten öffnen sich, sobald Sie einen zweiten Faktor eingerichtet haben.",
  to_account: "In Ihrem Konto einrichten",
  begin: "Einrichten",
  scan: "1. Lesen Sie dies mit der Authenticator-App Ihres Telefons ein.",
  qr: "QR-Code für eine Authenticator-App; dasselbe wie der Schlüssel darunter, den man eintippen kann",
  or_type: "Oder tippen Sie diesen Schlüssel ein:",
  confirm: "Einschalten",
  code: "Code Ihres Geräts",
  code_hint: "Sechs Ziffern, die alle 30 Sekunden wechseln.",
  recovery_code: "Ersatzcode",
  recovery_code_hint: "Einer der zehn, die Sie aufbewahrt haben. Jeder gilt einmal.",
  recovery_title: "Ihre Ersatzcodes",
  recovery_text: "Ab jetzt werden Sie beim Anmelden nach einem Code gefragt. Bewahren Sie diese dort auf, wo Sie sie ohne Ihr Telefon finden: Jeder lässt Sie einmal hinein, anstelle eines Codes. Sie werden nicht noch einmal gezeigt.",
  kept: "Ich habe sie aufbewahrt",
  set_up_since: (day) => `Eingerichtet seit ${day}.`,
  codes_left: (left) => (left === 1 ? "Ein Ersatzcode ist übrig." : `${left.toFixed(0)} Ersatzcodes sind übrig.`),
  renew: "Neue Ersatzcodes …",
  remove: "Entfernen …",
  remove_required: "Sie gehören zur Verwaltung: Davon ist nichts offen, bis Sie ihn wieder einrichten.",
  ask: {
    renew: { title: "Neue Ersatzcodes?", text: "Die alten gelten dann nicht mehr. Bestätigen Sie mit Ihrem Passwort und einem Code.", yes: "Neue erstellen" },
    remove: { title: "Zweiten Faktor entfernen?", text: "Dann genügt Ihr Passwort allein. Bestätigen Sie damit und mit einem Code; ein Ersatzcode geht auch.", yes: "Entfernen" },
  },
  sign_in_lead: "Ihr Passwort stimmt. Jetzt der Code.",
  use_recovery: "Einen Ersatzcode benutzen",
  use_device: "Den Code meines Geräts benutzen",
  back: "Zurück",
};
