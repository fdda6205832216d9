#pragma once

#include <string>

#include "api/studies/studies.h"

namespace diaphane::api {

/// Sends exports to the analysis service (studies/ at the top of the repository) with libcurl.
class AnalysisClient final : public StudyAnalysis {
 public:
  /// `url` is the service's origin, such as "http://127.0.0.1:8090", or empty if there is none.
  explicit AnalysisClient(std::string url) : url_(std::move(url)) {}
  Result<std::string> analyse(const std::string& export_path, const std::string& language) override;

 private:
  std::string url_;
};

}  // namespace diaphane::api
