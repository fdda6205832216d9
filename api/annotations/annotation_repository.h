#pragma once

#include "api/annotations/annotations.h"
#include "api/shared/database.h"

namespace diaphane::api {

/// The table `annotations` (migrations/0022).
class AnnotationRepository final : public AnnotationStore {
 public:
  explicit AnnotationRepository(Database& database) : database_(database) {}

  Result<std::vector<AnnotationSet>> list(const std::string& data_set_id,
                                          const std::string& viewer_id) override;
  Result<void> add(const AnnotationSet& set, int most) override;
  Result<void> change(const AnnotationSet& set, const AnnotationChange& what, Time now) override;
  Result<void> remove(const AnnotationSet& set) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
