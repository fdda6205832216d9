#pragma once

#include "api/scans/alignments.h"
#include "api/shared/database.h"

namespace diaphane::api {

/// The alignments of scans in Postgres (migrations/0031, 0033).
class AlignmentRepository final : public AlignmentStore {
 public:
  explicit AlignmentRepository(Database& database) : database_(database) {}
  Result<Alignment> find(const std::string& first, const std::string& second) override;
  Result<Request> request(const std::string& user_id, const std::string& first,
                          const std::string& second, int most, Time now) override;
  Result<bool> remove(const std::string& first, const std::string& second) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
