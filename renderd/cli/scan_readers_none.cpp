// On machines without GDCM and VTK (-DDIAPHANE_INGEST=OFF) only volumes that are stored already can
// be rendered.
#include "renderd/cli/scan_readers.h"

namespace diaphane::render::cli {
namespace {

tl::unexpected<Error> without_readers() {
  return fail(
      ErrorCode::kUnsupported,
      "this program was built without the readers of scans (DIAPHANE_INGEST): it reads only "
      "directories of the volume store");
}

}  // namespace

Result<volume::Volume> read_dicom_folder(const std::string&) { return without_readers(); }
Result<volume::Volume> read_image_file(const std::string&) { return without_readers(); }

}  // namespace diaphane::render::cli
