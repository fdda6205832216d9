#pragma once

#include <memory>
#include <string>

#include "api/privacy/exports.h"

namespace diaphane::api {

/// Writes a zip file of any size (zip64 if needed) as a stream, without holding it in memory. Uses
/// the fastest compression level.
class ZipWriter final : public ExportFile {
 public:
  /// Returns kUnavailable if the file cannot be created.
  static Result<std::unique_ptr<ExportFile>> create(const std::string& path);
  ~ZipWriter() override;

  Result<void> add(const std::string& name, std::string_view text) override;
  Result<void> add_file(const std::string& name, const std::string& path) override;
  Result<std::int64_t> finish() override;

 private:
  struct Impl;
  explicit ZipWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::api
