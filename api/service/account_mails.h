#pragma once

#include <string>

#include "api/service/account_store.h"

/// The emails about accounts. `link` is a complete URL with its token.
namespace diaphane::api::mails {

Mail welcome(const std::string& to, const std::string& link);
Mail already_there(const std::string& to, const std::string& sign_in);
Mail reset(const std::string& to, const std::string& link);
Mail no_account(const std::string& to, const std::string& sign_up);
Mail password_changed(const std::string& to, const std::string& forgot);
/// Sent to the new address.
Mail confirm_new_address(const std::string& to, const std::string& link);
Mail new_address_taken(const std::string& to, const std::string& sign_in);
/// Sent to the old address.
Mail address_asked_to_change(const std::string& to, const std::string& forgot);
Mail address_changed(const std::string& to);
/// `account` is the URL of the page to renew codes or to turn off two-factor authentication.
Mail second_factor_added(const std::string& to, const std::string& account);
Mail second_factor_removed(const std::string& to, const std::string& account);
/// For `diaphane-api admin reset-2fa`, run by the operator of the server.
Mail second_factor_taken_off(const std::string& to);
Mail recovery_code_used(const std::string& to, const std::string& account);
Mail code_reused(const std::string& to, const std::string& account);
Mail recovery_codes_renewed(const std::string& to, const std::string& account);
Mail account_deleted(const std::string& to);

}  // namespace diaphane::api::mails
