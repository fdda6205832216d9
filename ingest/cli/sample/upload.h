#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "common/result.h"

namespace diaphane::sample {

/// Collects files into the bundle that a browser makes (docs/contracts.md, "Upload bundle"): a
/// ustar archive of 00001.dcm, 00002.dcm, ..., without owners, times or original names.
class Bundle {
 public:
  Result<void> add(const std::string& file);
  /// Ends the archive and returns its bytes.
  std::string finish();
  std::size_t files() const { return files_; }

 private:
  std::string bytes_;
  std::size_t files_ = 0;
};

struct UploadOptions {
  std::string url;    ///< origin of the edge or of `api`, "http://127.0.0.1:8080"
  std::string token;  ///< the sample token
  std::string title;
  /// Called with the bytes sent and the total as the upload proceeds.
  std::function<void(std::uint64_t, std::uint64_t)> progress = [](std::uint64_t, std::uint64_t) {};
};

/// Uploads `bundle` with tus 1.0, resuming after interruptions, and waits until the data set is
/// ready. Returns its ID, kInvalid with the text of a refusal, or kUnavailable if there is no
/// response for a minute.
Result<std::string> upload(const std::string& bundle, std::size_t files,
                           const UploadOptions& options);

}  // namespace diaphane::sample
