// The same readers as ingestd's, so that a scan which one accepts is what the other shows.
#include "ingest/build/read_folder.h"
#include "ingest/build/read_image.h"
#include "renderd/cli/scan_readers.h"

namespace diaphane::render::cli {

Result<volume::Volume> read_dicom_folder(const std::string& path) {
  return ingest::read_folder(path);
}

Result<volume::Volume> read_image_file(const std::string& path) {
  if (ingest::is_image_name(path)) return ingest::read_image(path);
  return fail(ErrorCode::kUnsupported,
              "the file is not named .mha, .mhd, .nii, .nii.gz or .nrrd; of DICOM files give the "
              "folder that holds the series");
}

}  // namespace diaphane::render::cli
