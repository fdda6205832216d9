#include "renderd/scene/environment_store.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <mutex>
#include <optional>

#include "common/fd.h"
#include "common/ids.h"
#include "common/try.h"

namespace diaphane::render {
namespace {

std::mutex mutex;
std::string& directory() {
  static auto* const path = new std::string;
  return *path;
}

std::string path_of(const std::string& id) {
  const std::lock_guard lock(mutex);
  return directory().empty() ? std::string() : directory() + "/" + id + ".hdr";
}

/// Reads the file of an environment. Returns nullopt if there is no such file.
Result<std::optional<std::string>> read_file(const std::string& id) {
  if (!is_id(id)) return fail(ErrorCode::kInvalid, "must be the ID of a stored environment");
  const std::string path = path_of(id);
  if (path.empty()) {
    return fail(ErrorCode::kInvalid, "refers to an environment that is stored on a server");
  }
  const auto unavailable = [] {
    return fail(ErrorCode::kUnavailable, "cannot be read at the moment");
  };
  const Fd file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  if (!file && errno == ENOENT) return std::nullopt;
  struct stat info {};
  if (!file || fstat(file.get(), &info) != 0) return unavailable();
  if (info.st_size > static_cast<off_t>(scene::kMostEnvironmentBytes)) {
    return fail(ErrorCode::kInvalid, "is a corrupted picture");
  }
  std::string bytes(static_cast<std::size_t>(info.st_size), '\0');
  if (!read_all(file.get(), bytes.data(), bytes.size())) return unavailable();
  return bytes;
}

}  // namespace

void set_environment_directory(std::string path) {
  const std::lock_guard lock(mutex);
  directory() = std::move(path);
}

Result<TextureSize> stored_size(const std::string& id) {
  const auto file = read_file(id);
  DIAPHANE_TRY(file);
  return *file ? texture_size(**file) : TextureSize{1, 1};
}

Result<TexturePicture> load_stored(const std::string& id) {
  const auto file = read_file(id);
  DIAPHANE_TRY(file);
  if (*file) return decode_texture(**file);
  return TexturePicture{{1, 1}, {}, {scene::to_rgbe(1, 1, 1)}};
}

}  // namespace diaphane::render
