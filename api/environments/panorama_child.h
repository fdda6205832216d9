#pragma once

#include <string>

#include "api/environments/environments.h"

namespace diaphane::api {

/// The internal argument that makes this program a child which reads a panorama.
inline constexpr const char* kPanoramaWord = "import-panorama";

/// Runs as the child: drops all rights, reads the file from its input, and writes the picture in
/// its stored form, or a word for what is wrong with the file as its report. Returns the exit code.
int run_panorama_child();

/// Imports each file in a child without rights (common/sandbox), because libraries parse it.
class SandboxedImporter final : public PanoramaImporter {
 public:
  /// `program` contains run_panorama_child().
  explicit SandboxedImporter(std::string program) : program_(std::move(program)) {}
  Result<ImportedPanorama> import(const std::string& file) override;

 private:
  const std::string program_;
};

/// Returns 32 x 16 pixels of a picture in its stored form, in hexadecimal sRGB.
std::string preview_of(const std::string& picture);

}  // namespace diaphane::api
