#include "api/scans/uploads.h"

#include <utility>

#include "common/ids.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

tl::unexpected<Problem> no_such_upload() {
  return refuse(ProblemKind::kNotFound, "Upload not found.");
}

/// Suggests a retry after a minute instead of a second, because someone has to free space.
tl::unexpected<Problem> storage_full() {
  return refuse(ProblemKind::kStorageFull,
                "The server's storage is full at the moment. The data uploaded so far is kept. Try "
                "again later.",
                std::chrono::minutes(1));
}

tl::unexpected<Problem> expired() {
  return refuse(ProblemKind::kUploadExpired,
                "This upload was inactive for too long and has expired. Start it again.");
}

/// Returns whether the upload no longer exists, unlike an upload that cannot be looked up at the
/// moment.
bool is_gone(const Problem& problem) {
  return problem.kind == ProblemKind::kNotFound || problem.kind == ProblemKind::kUploadExpired;
}

}  // namespace

Uploads::Uploads(DataSetStore& store, UploadFiles& files, const Clock& clock,
                 const Signals& signals, std::chrono::seconds upload_life,
                 std::int64_t reserve_bytes)
    : store_(store),
      files_(files),
      clock_(clock),
      signals_(signals),
      upload_life_(upload_life),
      reserve_bytes_(reserve_bytes) {}

Outcome<Upload> Uploads::find(const Principal& who, const std::string& id) {
  if (!is_id(id)) return no_such_upload();
  auto found = store_.find_upload({who.user_id}, id);
  if (!found && found.error().code == ErrorCode::kNotFound) return no_such_upload();
  if (!found) return refuse(found.error());
  const bool late = found->state == DataSetState::kUploading && found->expires_at <= clock_.wall();
  if (late || found->state == DataSetState::kExpired) return expired();
  return *std::move(found);
}

Outcome<tus::Part> Uploads::plan(const Upload& upload, const tus::PartRequest& request) const {
  return tus::plan_part(
      {upload.length, upload.received, upload.state != DataSetState::kUploading, false}, request);
}

Outcome<void> Uploads::check_part(const Principal& who, const std::string& id,
                                  std::string_view offset, std::string_view checksum,
                                  std::int64_t bytes) {
  const auto upload = find(who, id);
  DIAPHANE_TRY(upload);
  if (auto part = plan(*upload, {offset, checksum, bytes}); !part)
    return tl::unexpected(part.error());
  if (files_.free_bytes() - reserve_bytes_ < bytes) return storage_full();
  return {};
}

Outcome<Upload> Uploads::append(const Principal& who, const std::string& id,
                                std::string_view offset, std::string_view checksum,
                                std::string_view bytes) {
  const tus::PartRequest request{offset, checksum, static_cast<std::int64_t>(bytes.size())};
  auto upload = find(who, id);
  if (!upload) return upload;
  auto part = plan(*upload, request);
  DIAPHANE_TRY(part);
  if (part->checksum && !tus::fits(*part->checksum, bytes)) {
    return refuse(ProblemKind::kChecksumMismatch,
                  "This part was corrupted in transit and discarded. Send it again.");
  }
  if (bytes.empty()) return upload;
  if (files_.free_bytes() - reserve_bytes_ < request.bytes) return storage_full();

  auto file = files_.open(id, upload->received == 0);
  if (!file && file.error().code == ErrorCode::kConflict) {
    return refuse(ProblemKind::kLocked, file.error().message, std::chrono::seconds(1));
  }
  if (!file && file.error().code == ErrorCode::kTooLarge) return storage_full();
  if (!file) return refuse(file.error());
  // Checks again under the file's lock, because another part may have been recorded in between.
  upload = find(who, id);
  if (!upload) {
    if (is_gone(upload.error())) (void)files_.remove(id);
    return upload;
  }
  part = plan(*upload, request);
  DIAPHANE_TRY(part);
  if (auto done = file->write(part->offset, bytes); !done) {
    if (done.error().code == ErrorCode::kTooLarge) return storage_full();
    return refuse(done.error());
  }

  const auto now = clock_.wall();
  upload->expires_at = now + upload_life_;
  const std::int64_t reached = part->offset + request.bytes;
  const auto noted = store_.advance_upload(id, part->offset, reached, upload->expires_at, now);
  if (!noted && noted.error().code == ErrorCode::kConflict) {
    // The upload was deleted or has expired. Its file may have been deleted before this part was
    // written.
    if (auto still = find(who, id); !still) {
      if (is_gone(still.error())) (void)files_.remove(id);
      return still;
    }
    return refuse(
        ProblemKind::kOffsetMismatch,
        "More of the upload has arrived in the meantime. Check its offset and continue there.");
  }
  if (!noted) return refuse(noted.error());
  upload->received = reached;
  if (part->completes) upload->state = DataSetState::kQueued;
  return upload;
}

Outcome<void> Uploads::terminate(const Principal& who, const std::string& id) {
  if (!is_id(id)) return no_such_upload();
  const auto done = store_.cancel_upload({who.user_id}, id, clock_.wall());
  if (!done && done.error().code == ErrorCode::kNotFound) return no_such_upload();
  if (!done && done.error().code == ErrorCode::kConflict) {
    return refuse(ProblemKind::kUploadComplete,
                  "This upload is already complete. Delete the scan or its labels instead.");
  }
  if (!done) return refuse(done.error());
  signals_.raise(Signal::kDisposal);
  return {};
}

}  // namespace diaphane::api
