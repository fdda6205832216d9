#include "api/accounts/account_mails.h"

#include <utility>

namespace diaphane::api::mails {
namespace {

struct Text {
  std::string subject;
  std::string body;
};

Mail in_one(Language language, const std::string& to, Text english, Text german) {
  Text& text = language == Language::kGerman ? german : english;
  return {to, std::move(text.subject), std::move(text.body)};
}

/// Returns an email in both languages. The German text follows the English one.
Mail in_both(const std::string& to, const Text& english, const Text& german) {
  return {to, english.subject + " / " + german.subject, english.body + "\n-----\n\n" + german.body};
}

}  // namespace

Mail welcome(Language language, const std::string& to, const std::string& link) {
  return in_one(
      language, to,
      {"Confirm your email address for Diaphane",
       "Someone, probably you, signed up for Diaphane with this email address.\n\n"
       "To confirm the address and choose a password, open this link within two days:\n\n" +
           link +
           "\n\nIf you did not sign up, ignore this email. Nobody can use the account without "
           "the link.\n"},
      {"Bestätigen Sie Ihre E-Mail-Adresse für Diaphane",
       "Jemand, vermutlich Sie, hat mit dieser E-Mail-Adresse ein Konto bei Diaphane "
       "angelegt.\n\nUm die Adresse zu bestätigen und ein Passwort festzulegen, öffnen Sie "
       "innerhalb von zwei Tagen diesen Link:\n\n" +
           link +
           "\n\nWenn Sie kein Konto angelegt haben, ignorieren Sie diese E-Mail. Ohne den Link "
           "kann niemand das Konto verwenden.\n"});
}

Mail already_there(Language language, const std::string& to, const std::string& sign_in) {
  return in_one(
      language, to,
      {"You already have a Diaphane account",
       "Someone, probably you, tried to sign up for Diaphane with this email address, but it "
       "already has an account. Nothing was changed.\n\nYou can sign in here:\n\n" +
           sign_in + "\n\nIf this was not you, you do not need to do anything.\n"},
      {"Sie haben schon ein Konto bei Diaphane",
       "Jemand, vermutlich Sie, wollte mit dieser E-Mail-Adresse ein Konto bei Diaphane anlegen. "
       "Zu der Adresse gibt es aber schon ein Konto. Es wurde nichts geändert.\n\nHier können Sie "
       "sich anmelden:\n\n" +
           sign_in + "\n\nWenn Sie das nicht waren, brauchen Sie nichts zu tun.\n"});
}

Mail reset(Language language, const std::string& to, const std::string& link) {
  return in_one(
      language, to,
      {"Reset your Diaphane password",
       "Someone, probably you, asked to reset the password of your Diaphane account.\n\n"
       "To choose a new password, open this link within one hour:\n\n" +
           link + "\n\nIf this was not you, ignore this email. Your password stays the same.\n"},
      {"Setzen Sie Ihr Passwort für Diaphane zurück",
       "Jemand, vermutlich Sie, möchte das Passwort Ihres Kontos bei Diaphane zurücksetzen.\n\nUm "
       "ein neues Passwort festzulegen, öffnen Sie innerhalb einer Stunde diesen Link:\n\n" +
           link +
           "\n\nWenn Sie das nicht waren, ignorieren Sie diese E-Mail. Ihr Passwort bleibt "
           "unverändert.\n"});
}

Mail no_account(Language language, const std::string& to, const std::string& sign_up) {
  return in_one(
      language, to,
      {"There is no Diaphane account with this email address",
       "Someone, probably you, asked to reset a Diaphane password. There is no account with "
       "this email address. You may have signed up with a different one.\n\nYou can create an "
       "account here:\n\n" +
           sign_up + "\n\nIf this was not you, you do not need to do anything.\n"},
      {"Zu dieser E-Mail-Adresse gibt es kein Konto bei Diaphane",
       "Jemand, vermutlich Sie, wollte ein Passwort für Diaphane zurücksetzen. Zu dieser "
       "E-Mail-Adresse gibt es kein Konto. Vielleicht haben Sie sich mit einer anderen Adresse "
       "registriert.\n\nHier können Sie ein Konto anlegen:\n\n" +
           sign_up + "\n\nWenn Sie das nicht waren, brauchen Sie nichts zu tun.\n"});
}

Mail account_disabled(Language language, const std::string& to, const std::string& contact) {
  return in_one(
      language, to,
      {"Your Diaphane account is disabled",
       "Someone, probably you, asked to reset the password of your Diaphane account. An "
       "administrator has disabled this account, so its password can't be reset now.\n\nThis page "
       "says how to reach the administrator:\n\n" +
           contact + "\n\nIf this was not you, you do not need to do anything.\n"},
      {"Ihr Konto bei Diaphane ist gesperrt",
       "Jemand, vermutlich Sie, möchte das Passwort Ihres Kontos bei Diaphane zurücksetzen. Das "
       "Konto wurde von der Verwaltung gesperrt. Deshalb lässt sich das Passwort zurzeit nicht "
       "zurücksetzen.\n\nAuf dieser Seite steht, wie Sie die Verwaltung erreichen:\n\n" +
           contact + "\n\nWenn Sie das nicht waren, brauchen Sie nichts zu tun.\n"});
}

Mail password_changed(Language language, const std::string& to, const std::string& forgot) {
  return in_one(
      language, to,
      {"Your Diaphane password was changed",
       "The password of your Diaphane account has just been changed. All your other devices "
       "and browsers were signed out.\n\nIf this was not you, reset your password now:\n\n" +
           forgot + "\n"},
      {"Ihr Passwort für Diaphane wurde geändert",
       "Das Passwort Ihres Kontos bei Diaphane wurde soeben geändert. Alle Ihre anderen Geräte und "
       "Browser wurden abgemeldet.\n\nWenn Sie das nicht waren, setzen Sie Ihr Passwort jetzt "
       "zurück:\n\n" +
           forgot + "\n"});
}

Mail confirm_new_address(Language language, const std::string& to, const std::string& link) {
  return in_one(
      language, to,
      {"Confirm your new email address for Diaphane",
       "Someone, probably you, wants to use this email address for an existing Diaphane "
       "account.\n\nTo confirm the address, open this link within two days. You may have to "
       "sign in with your old email address first:\n\n" +
           link +
           "\n\nIf this was not you, ignore this email. The link works only for the account "
           "that requested the change.\n"},
      {"Bestätigen Sie Ihre neue E-Mail-Adresse für Diaphane",
       "Jemand, vermutlich Sie, möchte diese E-Mail-Adresse für ein bestehendes Konto bei Diaphane "
       "verwenden.\n\nUm die Adresse zu bestätigen, öffnen Sie innerhalb von zwei Tagen diesen "
       "Link. Möglicherweise müssen Sie sich vorher mit Ihrer alten E-Mail-Adresse anmelden:\n\n" +
           link +
           "\n\nWenn Sie das nicht waren, ignorieren Sie diese E-Mail. Der Link funktioniert nur "
           "für das Konto, das die Änderung angefordert hat.\n"});
}

Mail new_address_taken(Language language, const std::string& to, const std::string& sign_in) {
  return in_one(
      language, to,
      {"You already have a Diaphane account",
       "Someone, probably you, wanted to use this email address for another Diaphane account, "
       "but it already has an account. Nothing was changed.\n\nYou can sign in to that account "
       "here:\n\n" +
           sign_in + "\n\nIf this was not you, you do not need to do anything.\n"},
      {"Sie haben schon ein Konto bei Diaphane",
       "Jemand, vermutlich Sie, wollte diese E-Mail-Adresse für ein anderes Konto bei Diaphane "
       "verwenden. Zu der Adresse gibt es aber schon ein Konto. Es wurde nichts geändert.\n\nHier "
       "können Sie sich bei diesem Konto anmelden:\n\n" +
           sign_in + "\n\nWenn Sie das nicht waren, brauchen Sie nichts zu tun.\n"});
}

Mail address_change_requested(Language language, const std::string& to, const std::string& forgot) {
  return in_one(
      language, to,
      {"Your Diaphane email address is about to change",
       "Someone, probably you, asked to change the email address of your Diaphane account. The "
       "change takes effect once the new address is confirmed.\n\nIf this was not you, reset "
       "your password now. This also cancels the change:\n\n" +
           forgot + "\n"},
      {"Die E-Mail-Adresse Ihres Kontos bei Diaphane soll geändert werden",
       "Jemand, vermutlich Sie, möchte die E-Mail-Adresse Ihres Kontos bei Diaphane ändern. Die "
       "Änderung gilt, sobald die neue Adresse bestätigt ist.\n\nWenn Sie das nicht waren, setzen "
       "Sie Ihr Passwort jetzt zurück. Damit wird auch die Änderung abgebrochen:\n\n" +
           forgot + "\n"});
}

Mail address_changed(Language language, const std::string& to) {
  return in_one(
      language, to,
      {"The email address of your Diaphane account was changed",
       "Your Diaphane account now uses a different email address. You can no longer sign in "
       "with this one.\n\nIf this was not you, contact the administrator of this Diaphane "
       "server.\n"},
      {"Die E-Mail-Adresse Ihres Kontos bei Diaphane wurde geändert",
       "Ihr Konto bei Diaphane hat jetzt eine andere E-Mail-Adresse. Mit dieser Adresse können Sie "
       "sich nicht mehr anmelden.\n\nWenn Sie das nicht waren, wenden Sie sich an die "
       "Administration dieses Diaphane-Servers.\n"});
}

Mail second_factor_added(Language language, const std::string& to, const std::string& account) {
  return in_one(
      language, to,
      {"Two-factor authentication is now on for your Diaphane account",
       "Two-factor authentication was turned on for your Diaphane account. From now on, you "
       "need a code from your authenticator app to sign in. All your other devices and "
       "browsers were signed out.\n\nKeep your recovery codes where you can find them without "
       "the device that has your authenticator app.\n\nIf this was not you, contact the "
       "administrator of this Diaphane server and check your account:\n\n" +
           account + "\n"},
      {"Die Zwei-Faktor-Authentifizierung Ihres Kontos bei Diaphane ist jetzt aktiv",
       "Die Zwei-Faktor-Authentifizierung Ihres Kontos bei Diaphane wurde aktiviert. Ab jetzt "
       "brauchen Sie zum Anmelden einen Code aus Ihrer Authenticator-App. Alle Ihre anderen Geräte "
       "und Browser wurden abgemeldet.\n\nBewahren Sie Ihre Ersatzcodes dort auf, wo Sie sie auch "
       "ohne das Gerät mit Ihrer Authenticator-App finden.\n\nWenn Sie das nicht waren, wenden Sie "
       "sich an die Administration dieses Diaphane-Servers und prüfen Sie Ihr Konto:\n\n" +
           account + "\n"});
}

Mail second_factor_removed(Language language, const std::string& to, const std::string& account) {
  return in_one(
      language, to,
      {"Two-factor authentication is now off for your Diaphane account",
       "Two-factor authentication was turned off for your Diaphane account. From now on, you "
       "can sign in with your password alone.\n\nIf this was not you, change your password now "
       "and turn two-factor authentication on again:\n\n" +
           account + "\n"},
      {"Die Zwei-Faktor-Authentifizierung Ihres Kontos bei Diaphane ist jetzt deaktiviert",
       "Die Zwei-Faktor-Authentifizierung Ihres Kontos bei Diaphane wurde deaktiviert. Ab jetzt "
       "genügt zum Anmelden Ihr Passwort allein.\n\nWenn Sie das nicht waren, ändern Sie jetzt Ihr "
       "Passwort und aktivieren Sie die Zwei-Faktor-Authentifizierung wieder:\n\n" +
           account + "\n"});
}

Mail second_factor_taken_off(const std::string& to) {
  return in_both(
      to,
      {"Two-factor authentication is now off for your Diaphane account",
       "An administrator of this Diaphane server turned off two-factor authentication for your "
       "account. You can sign in with your password alone until you turn it on again.\n\nIf "
       "you did not ask for this, contact the administrator now.\n"},
      {"Die Zwei-Faktor-Authentifizierung ist jetzt deaktiviert",
       "Die Administration dieses Diaphane-Servers hat die Zwei-Faktor-Authentifizierung Ihres "
       "Kontos deaktiviert. Zum Anmelden genügt Ihr Passwort allein, bis Sie sie wieder "
       "aktivieren.\n\nWenn Sie nicht darum gebeten haben, wenden Sie sich jetzt an die "
       "Administration.\n"});
}

Mail recovery_code_used(Language language, const std::string& to, const std::string& account) {
  return in_one(language, to,
                {"A recovery code of your Diaphane account was used",
                 "One of your recovery codes has just been used instead of a code from your "
                 "authenticator app. It can't be used again. See how many are left or generate new "
                 "ones:\n\n" +
                     account + "\n\nIf this was not you, change your password now.\n"},
                {"Ein Ersatzcode Ihres Kontos bei Diaphane wurde verwendet",
                 "Einer Ihrer Ersatzcodes wurde soeben anstelle eines Codes aus Ihrer "
                 "Authenticator-App verwendet. Er gilt nun nicht mehr. Hier sehen Sie, wie viele "
                 "Sie noch haben, und können neue erstellen:\n\n" +
                     account + "\n\nWenn Sie das nicht waren, ändern Sie jetzt Ihr Passwort.\n"});
}

Mail code_reused(Language language, const std::string& to, const std::string& account) {
  return in_one(
      language, to,
      {"A code for your Diaphane account was used twice",
       "A code from your authenticator app has just been entered a second time, together with "
       "your password. It was refused because each code works only once.\n\nIf this was you, "
       "nothing is wrong. Wait for the next code.\n\nIf this was not you, someone knows your "
       "password and has seen your code. Change your password now:\n\n" +
           account + "\n"},
      {"Ein Code für Ihr Konto bei Diaphane wurde zweimal verwendet",
       "Ein Code aus Ihrer Authenticator-App wurde soeben zum zweiten Mal eingegeben, zusammen mit "
       "Ihrem Passwort. Er wurde abgelehnt, weil jeder Code nur einmal gilt.\n\nWenn Sie das "
       "waren, ist alles in Ordnung. Warten Sie auf den nächsten Code.\n\nWenn Sie das nicht "
       "waren, kennt jemand Ihr Passwort und hat Ihren Code gesehen. Ändern Sie jetzt Ihr "
       "Passwort:\n\n" +
           account + "\n"});
}

Mail recovery_codes_renewed(Language language, const std::string& to, const std::string& account) {
  return in_one(
      language, to,
      {"Your Diaphane account has new recovery codes",
       "New recovery codes were generated for your Diaphane account. The old codes no longer "
       "work.\n\nIf this was not you, change your password now:\n\n" +
           account + "\n"},
      {"Ihr Konto bei Diaphane hat neue Ersatzcodes",
       "Für Ihr Konto bei Diaphane wurden neue Ersatzcodes erstellt. Die alten Codes gelten nicht "
       "mehr.\n\nWenn Sie das nicht waren, ändern Sie jetzt Ihr Passwort:\n\n" +
           account + "\n"});
}

Mail api_token_created(Language language, const std::string& to, const std::string& name,
                       const std::string& account) {
  return in_one(
      language, to,
      {"A new API token was created for your Diaphane account",
       "The API token \"" + name +
           "\" was created for your Diaphane account. A program that has it can use your account "
           "without your password. You can see and revoke your tokens here:\n\n" +
           account + "\n\nIf this was not you, revoke the token and change your password now.\n"},
      {"Für Ihr Konto bei Diaphane wurde ein neues API-Token erstellt",
       "Für Ihr Konto bei Diaphane wurde das API-Token „" + name +
           "“ erstellt. Ein Programm, das dieses Token hat, kann Ihr Konto ohne Ihr Passwort "
           "nutzen. Hier sehen Sie Ihre Tokens und können sie widerrufen:\n\n" +
           account +
           "\n\nWenn Sie das nicht waren, widerrufen Sie das Token und ändern Sie jetzt Ihr "
           "Passwort.\n"});
}

Mail account_deleted(Language language, const std::string& to) {
  return in_one(
      language, to,
      {"Your Diaphane account was deleted",
       "Your Diaphane account was deleted, together with your scans, images, presets and "
       "recordings. This is the last email that you will get from us. We do not keep your "
       "email address.\n"},
      {"Ihr Konto bei Diaphane wurde gelöscht",
       "Ihr Konto bei Diaphane wurde gelöscht, zusammen mit Ihren Aufnahmen, Bildern, "
       "Voreinstellungen und "
       "Aufzeichnungen. Dies ist die letzte E-Mail, die Sie von uns erhalten. Wir bewahren Ihre "
       "E-Mail-Adresse nicht auf.\n"});
}

Mail invitation(const std::string& to, const std::string& name, const std::string& from,
                const std::string& scans) {
  const std::string sender = name.empty() ? from : name + " (" + from + ")";
  return in_both(
      to,
      {"A scan was shared with you on Diaphane",
       sender +
           " shared a scan with you on Diaphane.\n\nTo see it, sign in with this email address or "
           "use it to create an account. You will find the scan under \"My scans\":\n\n" +
           scans +
           "\n\nThe owner can see when, how and roughly from where you view it.\n\nIf you do not "
           "know the sender, "
           "ignore this email. We do not tell anyone whether "
           "you have an account.\n"},
      {"Mit Ihnen wurde eine Aufnahme geteilt",
       sender +
           " hat auf Diaphane eine Aufnahme mit Ihnen geteilt.\n\nUm sie zu sehen, melden Sie sich "
           "mit dieser E-Mail-Adresse an oder erstellen Sie damit ein Konto. Sie finden die "
           "Aufnahme unter „Meine Aufnahmen“:\n\n" +
           scans +
           "\n\nWem die Aufnahme gehört, kann sehen, wann, auf welchem Weg und ungefähr von wo Sie "
           "sie ansehen."
           "\n\nWenn Sie den Absender nicht kennen, ignorieren Sie diese E-Mail. Wir verraten "
           "niemandem, ob Sie ein Konto haben.\n"});
}

}  // namespace diaphane::api::mails
