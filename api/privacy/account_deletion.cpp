#include "api/privacy/account_deletion.h"

#include "api/accounts/account_mails.h"
#include "api/accounts/attempts.h"
#include "common/log.h"

namespace diaphane::api {

Outcome<void> AccountDeletion::remove(const Principal& who, const std::string& password,
                                      const std::string& code) {
  if (auto right = accounts_.confirm_password(who, "password", password); !right) {
    return right;
  }
  if (auto right = accounts_.confirm_code(who, code); !right) return right;
  const std::string key = email_key(who.email);
  const auto data_sets = store_.remove_account(
      who.user_id, who.email,
      {attempt_key("account", key), attempt_key(kSignUpMails, key), attempt_key(kResetMails, key),
       attempt_key(kChangeMails, key), attempt_key("change", who.user_id)},
      mails::account_deleted(who.language, who.email), clock_.wall());
  if (!data_sets) return refuse(data_sets.error());
  // The rows are deleted, so no new session can be opened. Running ones are ended if possible.
  bool ended = placement_.end_all_by(who.user_id).has_value();
  for (const std::string& id : *data_sets) ended = placement_.end_all_of(id).has_value() && ended;
  if (!ended) log::warning("failed to end a deleted account's sessions");
  signals_.raise(Signal::kDisposal);
  signals_.raise(Signal::kMail);
  return {};
}

}  // namespace diaphane::api
