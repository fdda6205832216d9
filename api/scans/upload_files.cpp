#include "api/scans/upload_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>

#include "common/log.h"

namespace diaphane::api {
namespace {

bool is_full(int error) { return error == ENOSPC || error == EDQUOT || error == EFBIG; }

/// Removes the data after `start` to free space on a full disk, and returns the cause of the
/// failure.
tl::unexpected<Error> given_back(int fd, std::int64_t start, int error) {
  log::error("cannot write a part of an upload", {{"errno", error}});
  if (::ftruncate(fd, start) != 0) log::error("cannot truncate an upload file", {{"errno", errno}});
  return fail(is_full(error) ? ErrorCode::kTooLarge : ErrorCode::kUnavailable,
              "The server's storage is full at the moment. Try again later.");
}

}  // namespace

UploadFiles::Open::~Open() {
  if (fd_ >= 0) ::close(fd_);  // releases the lock
}

Result<void> UploadFiles::Open::write(std::int64_t offset, std::string_view bytes) {
  const std::int64_t start = offset;
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(fd_, bytes.data(), bytes.size(), offset);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return given_back(fd_, start, written < 0 ? errno : ENOSPC);
    bytes.remove_prefix(static_cast<std::size_t>(written));
    offset += written;
  }
  // Data that is recorded as received must survive a power failure, because the browser discards
  // its copy. A full disk may show only now, because some file systems allocate blocks late.
  if (::fdatasync(fd_) != 0) return given_back(fd_, start, errno);
  return {};
}

Result<UploadFiles::Open> UploadFiles::open(const std::string& id, bool create) {
  const int flags = O_WRONLY | O_CLOEXEC | O_NOFOLLOW | (create ? O_CREAT : 0);
  const int fd = ::open(path_of(id).c_str(), flags, 0640);
  if (fd < 0) {
    const int error = errno;
    log::error("cannot open an upload file", {{"errno", error}});
    return fail(is_full(error) ? ErrorCode::kTooLarge : ErrorCode::kUnavailable,
                "The server's storage is unavailable at the moment. Try again later.");
  }
  Open open(fd);
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    return fail(ErrorCode::kConflict, "Another part of this upload is still being written.");
  }
  return open;
}

Result<void> UploadFiles::remove(const std::string& id) {
  if (::unlink(path_of(id).c_str()) != 0 && errno != ENOENT) {
    return fail(ErrorCode::kUnavailable, "cannot delete the upload file");
  }
  return {};
}

std::int64_t UploadFiles::free_bytes() const {
  struct statvfs info {};
  if (::statvfs(directory_.c_str(), &info) != 0) return 0;
  return static_cast<std::int64_t>(info.f_bavail) * static_cast<std::int64_t>(info.f_frsize);
}

}  // namespace diaphane::api
