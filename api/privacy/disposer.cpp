#include "api/privacy/disposer.h"

#include <filesystem>

#include "common/ids.h"
#include "common/log.h"

namespace diaphane::api {
namespace {

constexpr int kDisposalsAtOnce = 100;

}  // namespace

int Disposer::dispose() {
  const auto due = store_.disposals(kDisposalsAtOnce);
  if (!due) return 0;
  int gone = 0;
  for (const Disposal& disposal : *due) {
    if (auto done = remove(disposal); !done) {
      log::warning("failed to delete files",
                   {{"id", disposal.id}, {"reason", done.error().message}});
      continue;
    }
    if (store_.disposed(disposal)) ++gone;
  }
  return gone;
}

Result<void> Disposer::remove(const Disposal& disposal) {
  if (!is_id(disposal.id)) return fail(ErrorCode::kInternal, "not a valid ID");
  if (disposal.kind == Disposal::Kind::kUpload) return files_.remove(disposal.id);
  if (disposal.kind == Disposal::Kind::kPictures) return thumbnails_.remove(disposal.id);
  if (disposal.kind == Disposal::Kind::kPreset) return preset_pictures_.remove(disposal.id);
  if (disposal.kind == Disposal::Kind::kEnvironment) return environments_.dispose(disposal.id);
  std::error_code error;
  if (disposal.kind == Disposal::Kind::kExport || disposal.kind == Disposal::Kind::kScanExport) {
    const char* ending = disposal.kind == Disposal::Kind::kExport ? ".zip" : ".scan";
    std::filesystem::remove(export_directory_ + "/" + disposal.id + ending, error);
    if (error) return fail(ErrorCode::kUnavailable, "cannot delete the export");
    return {};
  }
  std::filesystem::remove_all(volume_directory_ + "/" + disposal.id, error);
  if (error) return fail(ErrorCode::kUnavailable, "cannot delete the volume");
  return thumbnails_.remove(disposal.id);
}

}  // namespace diaphane::api
