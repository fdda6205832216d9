#include "api/service/account_mails.h"

namespace diaphane::api::mails {

Mail welcome(const std::string& to, const std::string& link) {
  return {to, "Confirm your address for Diaphane",
          "Someone, most likely you, signed up for Diaphane with this email address.\n\n"
          "Open this link within two days to confirm the address and choose your password:\n\n" +
              link +
              "\n\nIf you did not sign up, ignore this mail. Without the link, nobody can use the "
              "account.\n"};
}

Mail already_there(const std::string& to, const std::string& sign_in) {
  return {to, "You have a Diaphane account already",
          "Somebody, most likely you, tried to sign up for Diaphane with this address, which has "
          "an account already.\nNothing was changed. You can sign in here:\n\n" +
              sign_in + "\n\nIf it was not you, do nothing.\n"};
}

Mail reset(const std::string& to, const std::string& link) {
  return {to, "A new password for Diaphane",
          "Somebody, most likely you, wants a new password for the Diaphane account of this "
          "address.\n\nOpen this link within an hour to choose one:\n\n" +
              link + "\n\nIf it was not you, do nothing: the old password stays.\n"};
}

Mail no_account(const std::string& to, const std::string& sign_up) {
  return {to, "You have no Diaphane account with this address",
          "Somebody, most likely you, asked for a new password for Diaphane. There is no account "
          "with this address; perhaps it has another one.\n\nYou can sign up here:\n\n" +
              sign_up + "\n\nIf it was not you, do nothing.\n"};
}

Mail password_changed(const std::string& to, const std::string& forgot) {
  return {to, "Your Diaphane password was changed",
          "The password of your Diaphane account was changed just now, and you were signed out "
          "everywhere else.\n\nIf it was not you, choose a new one at once:\n\n" +
              forgot + "\n"};
}

Mail confirm_new_address(const std::string& to, const std::string& link) {
  return {to, "Confirm your new address for Diaphane",
          "Someone, most likely you, wants to use this email address for an existing Diaphane "
          "account.\n\nOpen this link within two days to confirm it. You may be asked to sign in "
          "with your old address first:\n\n" +
              link +
              "\n\nIf you did not ask for this, ignore this mail. The link works only for the "
              "account that asked.\n"};
}

Mail new_address_taken(const std::string& to, const std::string& sign_in) {
  return {to, "You have a Diaphane account already",
          "Somebody, most likely you, wants to use this address for another Diaphane account. It "
          "has an account already, so nothing was changed. You can sign in to it here:\n\n" +
              sign_in + "\n\nIf it was not you, do nothing.\n"};
}

Mail address_asked_to_change(const std::string& to, const std::string& forgot) {
  return {to, "Your Diaphane account is to get another address",
          "Somebody, most likely you, asked to use another address for your Diaphane account. It "
          "changes once the new one is confirmed.\n\nIf it was not you, choose a new password at "
          "once, and nothing will change:\n\n" +
              forgot + "\n"};
}

Mail address_changed(const std::string& to) {
  return {to, "Your Diaphane account has another address now",
          "Your Diaphane account uses another address from now on. This one is no longer known "
          "there.\n\nIf it was not you, answer whoever runs this Diaphane.\n"};
}

Mail second_factor_added(const std::string& to, const std::string& account) {
  return {
      to, "Signing in to Diaphane asks for a code now",
      "A second factor was set up for your Diaphane account: signing in asks for a code of your "
      "device from now on, and you were signed out everywhere else.\n\nKeep the recovery codes "
      "where you find them without that device.\n\nIf it was not you, answer whoever runs this "
      "Diaphane, and look here:\n\n" +
          account + "\n"};
}

Mail second_factor_removed(const std::string& to, const std::string& account) {
  return {
      to, "Signing in to Diaphane asks for no code any more",
      "The second factor of your Diaphane account was removed: the password alone is enough from "
      "now on.\n\nIf it was not you, change your password at once, and set it up again:\n\n" +
          account + "\n"};
}

Mail second_factor_taken_off(const std::string& to) {
  return {
      to, "Signing in to Diaphane asks for no code any more",
      "Whoever runs this Diaphane removed the second factor of your account: the password alone "
      "is enough until you set it up again.\n\nIf you did not ask for that, answer whoever runs "
      "this Diaphane at once.\n"};
}

Mail recovery_code_used(const std::string& to, const std::string& account) {
  return {
      to, "A recovery code of your Diaphane account was used",
      "One of your recovery codes was used just now, in place of a code of your device. It works "
      "no more; how many are left is said here, where you can make new ones:\n\n" +
          account + "\n\nIf it was not you, change your password at once.\n"};
}

Mail code_reused(const std::string& to, const std::string& account) {
  return {
      to, "A code for your Diaphane account was given twice",
      "A code of your device was given a second time just now, with your password, and was "
      "refused: each works once.\n\nIf it was you, nothing is wrong: wait for the next code. If it "
      "was not, somebody has seen your password and your device; change the password at "
      "once:\n\n" +
          account + "\n"};
}

Mail recovery_codes_renewed(const std::string& to, const std::string& account) {
  return {
      to, "Your Diaphane account has new recovery codes",
      "New recovery codes were made for your Diaphane account; the old ones work no more.\n\nIf "
      "it was not you, change your password at once:\n\n" +
          account + "\n"};
}

Mail account_deleted(const std::string& to) {
  return {to, "Your Diaphane account was deleted",
          "Your Diaphane account was deleted, with your scans, pictures, presets and recordings. "
          "This is the last mail, and this address is not kept.\n"};
}

}  // namespace diaphane::api::mails
