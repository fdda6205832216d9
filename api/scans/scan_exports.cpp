#include "api/scans/scan_exports.h"

#include "common/ids.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

tl::unexpected<Problem> none() {
  return refuse(ProblemKind::kNotFound, "There is no export of this scan. Request one first.");
}

tl::unexpected<Problem> not_ready() {
  return refuse(ProblemKind::kNotReady, "This scan is not ready yet.");
}

}  // namespace

Outcome<ScanExport> ScanExports::request(const Principal& who, const std::string& data_set_id,
                                         const ScanExportOrder& order) {
  const auto scan = data_sets_.authorise(who, data_set_id, Action::kExport);
  DIAPHANE_TRY(scan);
  if (scan->state != DataSetState::kReady) return not_ready();
  const Time now = clock_.wall();
  ScanExport made{.id = new_id(),
                  .data_set_id = data_set_id,
                  .order = order,
                  .state = "queued",
                  .problem_code = {},
                  .problem_text = {},
                  .created_at = now,
                  .expires_at = now + kLife};
  const auto done = store_.request(who.user_id, made, most_bytes_);
  if (!done) return refuse(done.error());
  switch (*done) {
    case ScanExportStore::Request::kMade:
      break;
    case ScanExportStore::Request::kBusy:
      return refuse(ProblemKind::kTooMany,
                    "Another export of yours is being created. Wait until it is ready, or delete "
                    "it.",
                    std::chrono::seconds(10));
    case ScanExportStore::Request::kFull:
      return refuse(ProblemKind::kStorageFull,
                    "The server's storage for exports is full at the moment. Try again later.",
                    std::chrono::minutes(10));
    case ScanExportStore::Request::kNotReady:
      return not_ready();
  }
  signals_.raise(Signal::kDisposal);
  return made;
}

Outcome<ScanExport> ScanExports::find(const Principal& who, const std::string& data_set_id) {
  DIAPHANE_TRY(data_sets_.authorise(who, data_set_id, Action::kExport));
  auto found = store_.find(who.user_id, data_set_id, clock_.wall());
  if (!found) return refuse(found.error());
  if (!*found) return none();
  return **std::move(found);
}

Outcome<void> ScanExports::remove(const Principal& who, const std::string& data_set_id) {
  DIAPHANE_TRY(data_sets_.authorise(who, data_set_id, Action::kExport));
  const auto done = store_.remove(who.user_id, data_set_id);
  if (!done) return refuse(done.error());
  if (!*done) return none();
  signals_.raise(Signal::kDisposal);
  return {};
}

Outcome<ScanExports::File> ScanExports::file(const Principal& who, const std::string& data_set_id) {
  const auto found = find(who, data_set_id);
  DIAPHANE_TRY(found);
  if (found->state != "ready") {
    return refuse(ProblemKind::kNotReady, "The export is not ready yet.");
  }
  const std::string& format = found->order.format;
  DIAPHANE_TRY(data_sets_.note_export_downloaded(who, data_set_id, format));
  File file{found->id + ".scan", "scan.nii.gz", "application/gzip"};
  if (format == "stl") file = {file.stored, "surface.stl", "model/stl"};
  if (format == "glb") file = {file.stored, "surface.glb", "model/gltf-binary"};
  return file;
}

void ScanExports::expire() { (void)store_.expire(clock_.wall()); }

}  // namespace diaphane::api
