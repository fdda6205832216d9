#include "api/scans/alignment_repository.h"

#include <locale>
#include <sstream>

#include "api/shared/audit_repository.h"

namespace diaphane::api {
namespace {

std::optional<double> number_or_nothing(const pqxx::field& field) {
  if (field.is_null()) return std::nullopt;
  return field.as<double>();
}

volume::Matrix matrix_of(const std::string& text) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  volume::Matrix matrix = volume::kIdentity;
  for (double& number : matrix) in >> number;
  return matrix;
}

Alignment read_alignment(const pqxx::row& row) {
  Alignment found;
  found.shares_frame = row["shares_frame"].as<bool>();
  if (found.shares_frame) {
    found.state = "ready";
    return found;
  }
  found.state = row["state"].as<std::string>();
  if (found.state == "ready") {
    found.matrix = matrix_of(row["matrix"].as<std::string>());
    if (row["swapped"].as<bool>()) found.matrix = volume::inverse_of_rigid(found.matrix);
    found.residual_mm = number_or_nothing(row["residual_mm"]);
    found.overlap = number_or_nothing(row["overlap"]);
  }
  if (found.state == "failed") found.reason = row["reason"].as<std::string>();
  return found;
}

}  // namespace

Result<Alignment> AlignmentRepository::find(const std::string& first, const std::string& second) {
  return database_.read([&](pqxx::work& transaction) -> Result<Alignment> {
    const pqxx::result found = transaction.exec_params(
        R"sql(
        SELECT COALESCE(one.frame_of_reference = other.frame_of_reference, false) AS shares_frame,
               COALESCE(a.state, 'none') AS state, COALESCE(a.fixed = other.id, false) AS swapped,
               array_to_string(a.matrix, ' ') AS matrix, a.residual_mm, a.overlap, COALESCE(a.reason, '') AS reason
          FROM data_sets one CROSS JOIN data_sets other
          LEFT JOIN alignments a ON (a.fixed, a.moving) IN ((one.id, other.id), (other.id, one.id))
         WHERE one.id = $1::uuid AND other.id = $2::uuid
         ORDER BY a.state = 'ready' DESC, swapped
         LIMIT 1)sql",
        first, second);
    if (found.empty()) return fail(ErrorCode::kNotFound, "Scan not found.");
    return read_alignment(found[0]);
  });
}

Result<AlignmentStore::Request> AlignmentRepository::request(const std::string& user_id,
                                                             const std::string& first,
                                                             const std::string& second, int most,
                                                             Time now) {
  return database_.transact([&](pqxx::work& transaction) -> Result<Request> {
    // One request of an account at a time, so that it keeps to its limit.
    transaction.exec_params("SELECT 1 FROM users WHERE id = $1::uuid FOR UPDATE", user_id);
    // Waits for an order to anonymise one of the scans, which deletes their alignments.
    const pqxx::result ready = transaction.exec_params(
        "SELECT 1 FROM data_sets WHERE id IN ($1::uuid, $2::uuid) AND state = 'ready' ORDER BY id "
        "FOR SHARE",
        first, second);
    if (ready.size() != 2) return Request::kNotReady;
    transaction.exec_params0(
        R"sql(
        DELETE FROM alignments
         WHERE (fixed, moving) IN (($1::uuid, $2::uuid), ($2::uuid, $1::uuid)) AND state = 'failed')sql",
        first, second);
    const auto unfinished = transaction.exec_params1(
        "SELECT count(*) FROM alignments WHERE requested_by = $1::uuid AND state IN ('waiting', "
        "'running')",
        user_id);
    if (unfinished[0].as<int>() >= most) return Request::kTooMany;
    const pqxx::result made = transaction.exec_params(
        R"sql(
        INSERT INTO alignments (fixed, moving, requested_by, created_at)
        SELECT $1::uuid, $2::uuid, $3::uuid, to_timestamp($4::bigint / 1e6)
         WHERE NOT EXISTS (SELECT 1 FROM alignments WHERE fixed = $2::uuid AND moving = $1::uuid)
        ON CONFLICT DO NOTHING)sql",
        first, second, user_id, to_us(now));
    if (made.affected_rows() == 0) return Request::kKnown;
    transaction.exec("NOTIFY ingest_jobs");
    for (const std::string& id : {first, second}) {
      note_in_audit_log(
          transaction,
          {AuditActor::kPerson, user_id, "data-set.alignment-asked", "data_set", id, {}}, now);
    }
    return Request::kMade;
  });
}

Result<bool> AlignmentRepository::remove(const std::string& first, const std::string& second) {
  return database_.transact([&](pqxx::work& transaction) -> Result<bool> {
    const pqxx::result gone = transaction.exec_params(
        "DELETE FROM alignments WHERE (fixed, moving) IN (($1::uuid, $2::uuid), ($2::uuid, "
        "$1::uuid))",
        first, second);
    return gone.affected_rows() > 0;
  });
}

}  // namespace diaphane::api
