#include "ingest/build/read_folder.h"

#include "common/try.h"
#include "ingest/build/build_volume.h"

namespace diaphane::ingest {

Result<volume::Volume> read_folder(const std::string& path) {
  const dicom::ScanLimits limits;
  auto source = dicom::FolderSource::open(path, limits.file.file_bytes);
  DIAPHANE_TRY(source);
  auto scan = dicom::scan(*source, limits);
  DIAPHANE_TRY(scan);
  const dicom::Choice choice = dicom::choose_largest(*scan);
  if (!choice.suitable) return fail(ErrorCode::kInvalid, choice.text);
  auto built = build_volume(*source, *scan, choice, limits.file);
  DIAPHANE_TRY(built);
  return std::move(built->volume);
}

}  // namespace diaphane::ingest
