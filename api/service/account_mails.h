#pragma once

#include <string>

#include "api/service/account_store.h"

/// The mails about accounts. `link` is a whole one, with its token.
namespace diaphane::api::mails {

Mail welcome(const std::string& to, const std::string& link);
Mail already_there(const std::string& to, const std::string& sign_in);
Mail reset(const std::string& to, const std::string& link);
Mail no_account(const std::string& to, const std::string& sign_up);
Mail password_changed(const std::string& to, const std::string& forgot);
/// To the new address.
Mail confirm_new_address(const std::string& to, const std::string& link);
Mail new_address_taken(const std::string& to, const std::string& sign_in);
/// To the old one.
Mail address_asked_to_change(const std::string& to, const std::string& forgot);
Mail address_changed(const std::string& to);
/// `account` is the page where codes are renewed and the factor removed.
Mail second_factor_added(const std::string& to, const std::string& account);
Mail second_factor_removed(const std::string& to, const std::string& account);
/// By whoever runs this Diaphane, with a command on the machine.
Mail second_factor_taken_off(const std::string& to);
Mail recovery_code_used(const std::string& to, const std::string& account);
Mail code_reused(const std::string& to, const std::string& account);
Mail recovery_codes_renewed(const std::string& to, const std::string& account);
Mail account_deleted(const std::string& to);

}  // namespace diaphane::api::mails
