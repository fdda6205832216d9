#include "ingest/pipeline/export_jobs.h"

#include <array>
#include <string_view>
#include <utility>

#include "common/bounded_json.h"
#include "common/try.h"
#include "ingest/pipeline/postgres_link.h"

namespace diaphane::ingest {
namespace {

constexpr std::array<std::pair<ExportFormat, std::string_view>, 3> kFormats{
    {{ExportFormat::kNiftiGz, "nifti"}, {ExportFormat::kStl, "stl"}, {ExportFormat::kGlb, "glb"}}};

std::optional<ExportFormat> format_of(std::string_view text) {
  for (const auto& [format, name] : kFormats) {
    if (name == text) return format;
  }
  return std::nullopt;
}

ExportJob job_of(const pqxx::row& row) {
  ExportJob job;
  job.id = row["id"].as<std::string>();
  job.data_set_id = row["data_set_id"].as<std::string>();
  // The table allows only these formats.
  job.order.format = format_of(row["format"].as<std::string>()).value_or(ExportFormat::kNiftiGz);
  if (!row["label"].is_null()) job.order.label = row["label"].as<std::uint32_t>();
  if (!row["above"].is_null()) job.order.above = row["above"].as<std::int32_t>();
  job.order.phase = row["phase"].as<std::uint32_t>();
  job.attempts = row["attempts"].as<int>();
  job.waits = row["waits"].as<int>();
  return job;
}

}  // namespace

std::string to_text(const ExportOrder& order) {
  nlohmann::json json{{"format", "nifti"}};
  for (const auto& [format, name] : kFormats) {
    if (format == order.format) json["format"] = name;
  }
  if (order.label) json["label"] = *order.label;
  if (order.above) json["above"] = *order.above;
  if (order.phase > 0) json["phase"] = order.phase;
  return json.dump();
}

std::optional<ExportOrder> export_order_of(const std::string& text) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("format") || !json["format"].is_string())
    return std::nullopt;
  const auto format = format_of(json["format"].get<std::string>());
  if (!format) return std::nullopt;
  ExportOrder order;
  order.format = *format;
  if (json.contains("label")) order.label = json["label"].get<std::uint32_t>();
  if (json.contains("above")) order.above = json["above"].get<std::int32_t>();
  order.phase = json.value("phase", 0U);
  return order;
}

struct PostgresExports::Impl : LeasedLink {
  using LeasedLink::LeasedLink;
};

PostgresExports::PostgresExports(LeaseOptions options)
    : impl_(std::make_unique<Impl>(std::move(options))) {}
PostgresExports::~PostgresExports() = default;

Result<std::optional<ExportJob>> PostgresExports::claim() {
  return impl_->transact([&](pqxx::work& transaction) -> std::optional<ExportJob> {
    // Returns the number of earlier attempts, and counts this one until it has a result.
    const auto rows = transaction.exec_params(
        R"sql(
        WITH next AS (
          SELECT e.id FROM scan_exports e JOIN data_sets d ON d.id = e.data_set_id
           WHERE e.state = 'queued' AND d.state = 'ready' AND e.not_before <= now()
             AND (e.leased_until IS NULL OR e.leased_until <= now())
           ORDER BY e.created_at LIMIT 1 FOR UPDATE OF e SKIP LOCKED)
        UPDATE scan_exports e
           SET leased_by = $1, leased_until = now() + make_interval(secs => $2), attempts = attempts + 1
          FROM next WHERE e.id = next.id
        RETURNING e.id, e.data_set_id, e.format, e.label, e.above, e.phase, e.attempts - 1 AS attempts, e.waits)sql",
        impl_->claimer, impl_->lease_seconds);
    if (rows.empty()) return std::nullopt;
    return job_of(rows[0]);
  });
}

Result<bool> PostgresExports::renew(const ExportJob& job) {
  return impl_->transact([&](pqxx::work& transaction) {
    return transaction
               .exec_params(
                   R"sql(
                   UPDATE scan_exports SET leased_until = now() + make_interval(secs => $3)
                    WHERE id = $1 AND leased_by = $2 AND state = 'queued')sql",
                   job.id, impl_->claimer, impl_->lease_seconds)
               .affected_rows() > 0;
  });
}

Result<bool> PostgresExports::finish(const ExportJob& job, std::uint64_t bytes) {
  return impl_->transact([&](pqxx::work& transaction) {
    return transaction
               .exec_params(
                   R"sql(
                   UPDATE scan_exports
                      SET state = 'ready', bytes = $3, waiting = false, leased_by = NULL, leased_until = NULL,
                          expires_at = now() + interval '1 day'
                    WHERE id = $1 AND leased_by = $2 AND state = 'queued'
                      AND EXISTS (SELECT FROM data_sets WHERE id = data_set_id AND state = 'ready'))sql",
                   job.id, impl_->claimer, bytes)
               .affected_rows() > 0;
  });
}

Result<void> PostgresExports::fail_with(const ExportJob& job, const std::string& code,
                                        const std::string& text) {
  auto done = impl_->transact([&](pqxx::work& transaction) {
    return transaction
        .exec_params(
            R"sql(
            UPDATE scan_exports
               SET state = 'failed', bytes = NULL, problem_code = $3, problem_text = $4, leased_by = NULL,
                   leased_until = NULL
             WHERE id = $1 AND leased_by = $2 AND state = 'queued')sql",
            job.id, impl_->claimer, code, text)
        .affected_rows();
  });
  DIAPHANE_TRY(done);
  return {};
}

Result<void> PostgresExports::put_back(const ExportJob& job, std::chrono::milliseconds pause,
                                       bool waiting, bool count_attempt) {
  auto done = impl_->transact([&](pqxx::work& transaction) {
    return transaction
        .exec_params(
            R"sql(
            UPDATE scan_exports
               SET leased_by = NULL, leased_until = NULL, waiting = $4::bool,
                   waits = CASE WHEN $4::bool THEN waits + 1 ELSE waits END,
                   attempts = attempts - CASE WHEN $5::bool THEN 0 ELSE 1 END,
                   not_before = now() + make_interval(secs => $3),
                   expires_at = GREATEST(expires_at, now() + make_interval(secs => $3) + interval '1 day')
             WHERE id = $1 AND leased_by = $2 AND state = 'queued')sql",
            job.id, impl_->claimer, seconds_of(pause), waiting, count_attempt)
        .affected_rows();
  });
  DIAPHANE_TRY(done);
  return {};
}

}  // namespace diaphane::ingest
