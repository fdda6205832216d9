#include "renderd/cli/input.h"

#include <algorithm>
#include <filesystem>

#include "common/try.h"
#include "renderd/cli/scan_readers.h"
#include "volume/labels.h"

namespace diaphane::render::cli {

namespace {

std::uint32_t index_of(PhaseChoice phase, const volume::Header& header) {
  return phase.must_exist ? phase.index : std::min(phase.index, header.phase_count() - 1);
}

Result<volume::Volume> read_stored(const std::string& path, PhaseChoice phase) {
  const auto header = volume::read_header(path);
  DIAPHANE_TRY(header);
  return volume::read(path, /*verify_hash=*/false, index_of(phase, *header));
}

Result<volume::Volume> keep_one(Result<volume::Volume> volume, PhaseChoice phase) {
  DIAPHANE_TRY(volume);
  // The labels are those of all phases, as in the store.
  if (!volume->header.phases.empty()) cli::add_labels(*volume);
  DIAPHANE_TRY(volume::keep_phase(*volume, index_of(phase, volume->header)));
  return volume;
}

}  // namespace

Result<volume::Volume> read_input(const std::string& path, PhaseChoice phase) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) {
    return fail(ErrorCode::kNotFound, "no such file or folder: " + path);
  }
  if (fs::is_directory(status)) {
    if (fs::exists(fs::path(path) / "volume.json", error)) return read_stored(path, phase);
    return keep_one(read_dicom_folder(path), phase);
  }
  if (fs::is_regular_file(status)) return keep_one(read_image_file(path), phase);
  return fail(ErrorCode::kNotFound, "cannot read " + path);
}

Result<void> show_only_body(volume::Volume& volume) {
  if (volume.labels.empty()) add_labels(volume);
  return volume::hide_surroundings(volume);
}

}  // namespace diaphane::render::cli
