#include "api/service/account_mails.h"

namespace diaphane::api::mails {

Mail welcome(const std::string& to, const std::string& link) {
  return {to, "Confirm your email address for Diaphane",
          "Someone, probably you, signed up for Diaphane with this email address.\n\n"
          "To confirm the address and choose a password, open this link within two days:\n\n" +
              link +
              "\n\nIf you did not sign up, ignore this email. Nobody can use the account without "
              "the link.\n"};
}

Mail already_there(const std::string& to, const std::string& sign_in) {
  return {to, "You already have a Diaphane account",
          "Someone, probably you, tried to sign up for Diaphane with this email address, but it "
          "already has an account. Nothing was changed.\n\nYou can sign in here:\n\n" +
              sign_in + "\n\nIf this was not you, you do not need to do anything.\n"};
}

Mail reset(const std::string& to, const std::string& link) {
  return {to, "Reset your Diaphane password",
          "Someone, probably you, asked to reset the password of your Diaphane account.\n\n"
          "To choose a new password, open this link within one hour:\n\n" +
              link + "\n\nIf this was not you, ignore this email. Your password stays the same.\n"};
}

Mail no_account(const std::string& to, const std::string& sign_up) {
  return {to, "There is no Diaphane account with this email address",
          "Someone, probably you, asked to reset a Diaphane password. There is no account with "
          "this email address. You may have signed up with a different one.\n\nYou can create an "
          "account here:\n\n" +
              sign_up + "\n\nIf this was not you, you do not need to do anything.\n"};
}

Mail password_changed(const std::string& to, const std::string& forgot) {
  return {to, "Your Diaphane password was changed",
          "The password of your Diaphane account has just been changed. All your other devices "
          "and browsers were signed out.\n\nIf this was not you, reset your password now:\n\n" +
              forgot + "\n"};
}

Mail confirm_new_address(const std::string& to, const std::string& link) {
  return {to, "Confirm your new email address for Diaphane",
          "Someone, probably you, wants to use this email address for an existing Diaphane "
          "account.\n\nTo confirm the address, open this link within two days. You may have to "
          "sign in with your old email address first:\n\n" +
              link +
              "\n\nIf this was not you, ignore this email. The link works only for the account "
              "that requested the change.\n"};
}

Mail new_address_taken(const std::string& to, const std::string& sign_in) {
  return {to, "You already have a Diaphane account",
          "Someone, probably you, wanted to use this email address for another Diaphane account, "
          "but it already has an account. Nothing was changed.\n\nYou can sign in to that account "
          "here:\n\n" +
              sign_in + "\n\nIf this was not you, you do not need to do anything.\n"};
}

Mail address_asked_to_change(const std::string& to, const std::string& forgot) {
  return {to, "Your Diaphane email address is about to change",
          "Someone, probably you, asked to change the email address of your Diaphane account. The "
          "change takes effect once the new address is confirmed.\n\nIf this was not you, reset "
          "your password now. This also cancels the change:\n\n" +
              forgot + "\n"};
}

Mail address_changed(const std::string& to) {
  return {to, "The email address of your Diaphane account was changed",
          "Your Diaphane account now uses a different email address. You can no longer sign in "
          "with this one.\n\nIf this was not you, contact the administrator of this Diaphane "
          "server.\n"};
}

Mail second_factor_added(const std::string& to, const std::string& account) {
  return {to, "Two-factor authentication is now on for your Diaphane account",
          "Two-factor authentication was turned on for your Diaphane account. From now on, you "
          "need a code from your authenticator app to sign in. All your other devices and "
          "browsers were signed out.\n\nKeep your recovery codes where you can find them without "
          "the device that has your authenticator app.\n\nIf this was not you, contact the "
          "administrator of this Diaphane server and check your account:\n\n" +
              account + "\n"};
}

Mail second_factor_removed(const std::string& to, const std::string& account) {
  return {to, "Two-factor authentication is now off for your Diaphane account",
          "Two-factor authentication was turned off for your Diaphane account. From now on, you "
          "can sign in with your password alone.\n\nIf this was not you, change your password now "
          "and turn two-factor authentication on again:\n\n" +
              account + "\n"};
}

Mail second_factor_taken_off(const std::string& to) {
  return {to, "Two-factor authentication is now off for your Diaphane account",
          "An administrator of this Diaphane server turned off two-factor authentication for your "
          "account. You can sign in with your password alone until you turn it on again.\n\nIf "
          "you did not ask for this, contact the administrator now.\n"};
}

Mail recovery_code_used(const std::string& to, const std::string& account) {
  return {to, "A recovery code of your Diaphane account was used",
          "One of your recovery codes has just been used instead of a code from your "
          "authenticator app. It can't be used again. See how many are left or generate new "
          "ones:\n\n" +
              account + "\n\nIf this was not you, change your password now.\n"};
}

Mail code_reused(const std::string& to, const std::string& account) {
  return {to, "A code for your Diaphane account was used twice",
          "A code from your authenticator app has just been entered a second time, together with "
          "your password. It was refused because each code works only once.\n\nIf this was you, "
          "nothing is wrong. Wait for the next code.\n\nIf this was not you, someone knows your "
          "password and has seen your code. Change your password now:\n\n" +
              account + "\n"};
}

Mail recovery_codes_renewed(const std::string& to, const std::string& account) {
  return {to, "Your Diaphane account has new recovery codes",
          "New recovery codes were generated for your Diaphane account. The old codes no longer "
          "work.\n\nIf this was not you, change your password now:\n\n" +
              account + "\n"};
}

Mail account_deleted(const std::string& to) {
  return {to, "Your Diaphane account was deleted",
          "Your Diaphane account was deleted, together with your scans, images, presets and "
          "recordings. This is the last email that you will get from us. We do not keep your "
          "email address.\n"};
}

}  // namespace diaphane::api::mails
