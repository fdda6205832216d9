// Uses the readers of ingestd, so that both programs accept the same scans and show the same
// volumes.
#include "common/try.h"
#include "ingest/body/label_body.h"
#include "ingest/build/read_folder.h"
#include "ingest/build/read_image.h"
#include "ingest/labels/read_labels.h"
#include "ingest/registration/register.h"
#include "renderd/cli/scan_readers.h"

namespace diaphane::render::cli {

Result<volume::Volume> read_dicom_folder(const std::string& path) {
  return ingest::read_folder(path);
}

Result<volume::Volume> read_image_file(const std::string& path) {
  if (ingest::is_image_name(path)) return ingest::read_image(path);
  return fail(
      ErrorCode::kUnsupported,
      "the name of the file must end in .mha, .mhd, .nii, .nii.gz or .nrrd; for DICOM files, "
      "give the folder that contains the series");
}

Result<volume::LabelSet> read_label_file(const std::string& path, const volume::Header& scan) {
  return ingest::read_label_file(path, scan);
}

Result<volume::Matrix> align_scans(const volume::Volume& first, const volume::Volume& second) {
  const auto found = ingest::register_rigid(ingest::reduced(first), ingest::reduced(second));
  DIAPHANE_TRY(found);
  return found->to_fixed;
}

void add_labels(volume::Volume& volume) { volume.labels = ingest::found_labels(volume); }

}  // namespace diaphane::render::cli
