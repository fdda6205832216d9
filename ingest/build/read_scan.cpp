#include "ingest/build/read_scan.h"

#include <filesystem>

#include "ingest/build/read_folder.h"
#include "ingest/build/read_image.h"

namespace diaphane::ingest {

namespace fs = std::filesystem;

Result<volume::Volume> read_scan(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return fail(ErrorCode::kNotFound, "no such file or folder");
  if (!fs::is_directory(path, error)) {
    if (is_image_name(path)) return read_image(path);
    return fail(ErrorCode::kUnsupported, "the file is neither NIfTI, NRRD nor MetaImage");
  }
  if (fs::exists(fs::path(path) / "volume.json", error)) {
    return volume::read_all_phases(path, /*verify_hash=*/false);
  }
  return read_folder(path);
}

}  // namespace diaphane::ingest
