#pragma once

#include <string>

#include "api/environments/environments.h"

namespace diaphane::api {

/// The internal argument that makes the program run as the child that reads a panorama.
inline constexpr const char* kPanoramaWord = "import-panorama";

/// Runs as the child: enters the sandbox, reads the file from its input, and outputs the picture in
/// its stored form, or reports a word for the fault in the file. Returns the exit code.
int run_panorama_child();

/// Imports each file in a sandboxed child process (common/sandbox), because files are untrusted.
class SandboxedImporter final : public PanoramaImporter {
 public:
  /// `program` is the path of an executable that calls run_panorama_child() for kPanoramaWord.
  explicit SandboxedImporter(std::string program) : program_(std::move(program)) {}
  Result<ImportedPanorama> import(const std::string& file) override;

 private:
  const std::string program_;
};

/// Returns 32 x 16 sRGB pixels of a stored picture in hexadecimal, or "" if it is malformed.
std::string preview_of(const std::string& picture);

}  // namespace diaphane::api
