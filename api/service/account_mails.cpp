#include "api/service/account_mails.h"

namespace diaphane::api::mails {

Mail welcome(const std::string& to, const std::string& link) {
  return {to, "Confirm your address for Diaphane",
          "Somebody, most likely you, signed up for Diaphane with this address.\n\n"
          "Open this link within two days to confirm it:\n\n" +
              link +
              "\n\nIf it was not you, do nothing: without the link the account is of no use.\n"};
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
          "Somebody, most likely you, wants to use this address for a Diaphane account.\n\n"
          "Open this link within two days to confirm it:\n\n" +
              link + "\n\nIf it was not you, do nothing: nothing changes without the link.\n"};
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

Mail account_deleted(const std::string& to) {
  return {to, "Your Diaphane account was deleted",
          "Your Diaphane account was deleted, with your scans, pictures, presets and recordings. "
          "This is the last mail, and this address is not kept.\n"};
}

}  // namespace diaphane::api::mails
