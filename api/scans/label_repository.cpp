#include "api/scans/label_repository.h"

#include "api/accounts/account_repository.h"
#include "api/shared/audit_repository.h"

namespace diaphane::api {
namespace {

/// Locks the data set against a change of its labels, and deletes an upload in progress. Returns
/// whether the labels may be changed.
bool clear_the_way(pqxx::work& transaction, const std::string& data_set_id) {
  const pqxx::result found = transaction.exec_params(
      R"sql(
      SELECT id FROM data_sets
       WHERE id = $1 AND state = 'ready' FOR UPDATE)sql",
      data_set_id);
  if (found.empty()) return false;
  const pqxx::result jobs = transaction.exec_params(
      "SELECT data_set_id FROM ingest_jobs WHERE data_set_id = $1", data_set_id);
  if (!jobs.empty()) return false;
  transaction.exec_params0("DELETE FROM uploads WHERE data_set_id = $1 AND for_labels",
                           data_set_id);
  return true;
}

void note(pqxx::work& transaction, const Owner& owner, const char* action,
          const std::string& data_set_id, Time now) {
  note_in_audit_log(transaction,
                    {owner.user_id.empty() ? AuditActor::kMachine : AuditActor::kPerson,
                     owner.user_id,
                     action,
                     "data_set",
                     data_set_id,
                     {}},
                    now);
}

tl::unexpected<Error> busy() { return fail(ErrorCode::kConflict, "The scan is busy."); }

}  // namespace

Result<LabelStore::Beginning> LabelRepository::begin(const NewLabels& labels, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<Beginning> {
    // Locks the owner first, as every function that locks both does.
    const std::string& user_id = labels.owner.user_id;
    if (!user_id.empty()) (void)lock_quota(transaction, user_id);
    if (!clear_the_way(transaction, labels.data_set_id)) return busy();
    if (!user_id.empty()) {
      // The new quota excludes the upload that was just deleted.
      const Quota quota = lock_quota(transaction, user_id);
      if (labels.bytes > quota.bytes - quota.used) return OverQuota{quota};
    }
    transaction.exec_params0(R"sql(
        INSERT INTO uploads (id, data_set_id, length, expires_at, for_labels)
        VALUES ($1, $2, $3, to_timestamp($4::bigint / 1e6), true))sql",
                             labels.upload_id, labels.data_set_id, labels.bytes,
                             to_us(labels.expires_at));
    transaction.exec_params0(R"sql(
        UPDATE data_sets SET label_refusal_code = NULL, label_refusal_text = NULL,
                             updated_at = to_timestamp($2::bigint / 1e6)
         WHERE id = $1)sql",
                             labels.data_set_id, to_us(now));
    note(transaction, labels.owner, "data-set.labels-added", labels.data_set_id, now);
    return Begun{};
  });
}

Result<void> LabelRepository::remove(const Owner& owner, const std::string& data_set_id,
                                     const std::function<Result<void>()>& remove_file, Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<void> {
    if (!clear_the_way(transaction, data_set_id)) return busy();
    transaction.exec_params0(R"sql(
        UPDATE data_sets SET label_bytes = 0, label_count = 0, label_refusal_code = NULL,
                             label_refusal_text = NULL, updated_at = to_timestamp($2::bigint / 1e6)
         WHERE id = $1)sql",
                             data_set_id, to_us(now));
    note(transaction, owner, "data-set.labels-removed", data_set_id, now);
    // Runs under the lock, so that it cannot remove newer labels. A retry is harmless.
    return remove_file();
  });
}

}  // namespace diaphane::api
