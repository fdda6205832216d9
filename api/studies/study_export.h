#pragma once

#include <functional>
#include <memory>
#include <string>

#include "api/privacy/exports.h"
#include "api/studies/study_store.h"

namespace diaphane::api {

/// Writes the answers of a study into short-lived files, which the edge sends and the analysis
/// reads. Thread-safe.
class StudyExports {
 public:
  /// A file remains for this long, because the edge opens it just after the response.
  static constexpr std::chrono::minutes kFileLife{2};

  using MakeZip = std::function<Result<std::unique_ptr<ExportFile>>(const std::string& path)>;

  /// `directory` is the cache directory.
  StudyExports(StudyStore& store, MakeZip make_zip, const std::string& directory)
      : store_(store), make_zip_(std::move(make_zip)), directory_(directory) {}

  /// Each returns the name of a file below the cache directory (docs/contracts.md, "Studies").
  Result<std::string> write_json(const Study& study);
  Result<std::string> write_zip(const Study& study);
  Result<std::string> write_text(const std::string& text);

  std::string path_of(const std::string& name) const { return directory_ + "/" + name; }
  void remove(const std::string& name) const;
  /// Deletes files that are older than kFileLife.
  void expire() const;

 private:
  Result<std::string> new_name(const std::string& ending) const;

  StudyStore& store_;
  MakeZip make_zip_;
  std::string directory_;
};

}  // namespace diaphane::api
