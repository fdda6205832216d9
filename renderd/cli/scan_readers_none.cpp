// Without GDCM and VTK (-DDIAPHANE_INGEST=OFF), only stored volumes can be rendered.
#include "renderd/cli/scan_readers.h"

namespace diaphane::render::cli {
namespace {

tl::unexpected<Error> without_readers() {
  return fail(ErrorCode::kUnsupported,
              "this program was built without support for scan files (DIAPHANE_INGEST), so it can "
              "read only "
              "directories of the volume store");
}

}  // namespace

Result<volume::Volume> read_dicom_folder(const std::string&) { return without_readers(); }
Result<volume::Volume> read_image_file(const std::string&) { return without_readers(); }
Result<volume::LabelSet> read_label_file(const std::string&, const volume::Header&) {
  return without_readers();
}
Result<volume::Matrix> align_scans(const volume::Volume&, const volume::Volume&) {
  return without_readers();
}
void add_labels(volume::Volume&) {}

}  // namespace diaphane::render::cli
