#include "renderd/cli/input.h"

#include <filesystem>

#include "renderd/cli/scan_readers.h"
#include "volume/labels.h"

namespace diaphane::render::cli {

Result<volume::Volume> read_input(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) {
    return fail(ErrorCode::kNotFound, "no such file or folder: " + path);
  }
  if (fs::is_directory(status)) {
    if (fs::exists(fs::path(path) / "volume.json", error)) {
      return volume::read(path, /*verify_hash=*/false);
    }
    return read_dicom_folder(path);
  }
  if (fs::is_regular_file(status)) return read_image_file(path);
  return fail(ErrorCode::kNotFound, "cannot read " + path);
}

Result<void> show_only_body(volume::Volume& volume) {
  if (volume.labels.empty()) add_labels(volume);
  return volume::hide_surroundings(volume);
}

}  // namespace diaphane::render::cli
