#pragma once

#include <string>

#include "api/accounts/account_store.h"
#include "api/accounts/language.h"

/// The emails of the API. `link` is a complete URL with its token. `language` is that of the
/// request that causes the email. An email that someone other than the recipient causes is in both
/// languages, because the recipient's language is unknown.
namespace diaphane::api::mails {

Mail welcome(Language language, const std::string& to, const std::string& link);
Mail already_there(Language language, const std::string& to, const std::string& sign_in);
Mail reset(Language language, const std::string& to, const std::string& link);
Mail no_account(Language language, const std::string& to, const std::string& sign_up);
Mail account_disabled(Language language, const std::string& to, const std::string& contact);
Mail password_changed(Language language, const std::string& to, const std::string& forgot);
/// The next two emails are sent to the new address.
Mail confirm_new_address(Language language, const std::string& to, const std::string& link);
Mail new_address_taken(Language language, const std::string& to, const std::string& sign_in);
/// The next two emails are sent to the old address.
Mail address_change_requested(Language language, const std::string& to, const std::string& forgot);
Mail address_changed(Language language, const std::string& to);
/// `account` is the URL of the page to renew codes or to turn off two-factor authentication.
Mail second_factor_added(Language language, const std::string& to, const std::string& account);
Mail second_factor_removed(Language language, const std::string& to, const std::string& account);
/// Notifies a user after `diaphane-api admin reset-2fa` on the server, in both languages.
Mail second_factor_taken_off(const std::string& to);
Mail recovery_code_used(Language language, const std::string& to, const std::string& account);
Mail code_reused(Language language, const std::string& to, const std::string& account);
Mail recovery_codes_renewed(Language language, const std::string& to, const std::string& account);
/// `name` was chosen by the user and is shown only to the user.
Mail api_token_created(Language language, const std::string& to, const std::string& name,
                       const std::string& account);
Mail account_deleted(Language language, const std::string& to);
/// Invites a person in both languages. The sender chooses only two parts of this text: `name`,
/// which can hold no parenthesis, link or quotation mark (is_plain_name), and `from`, an email
/// address that was confirmed. The title of the scan is left out because it may say something about
/// a person's health.
Mail invitation(const std::string& to, const std::string& name, const std::string& from,
                const std::string& scans);

}  // namespace diaphane::api::mails
