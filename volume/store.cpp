#include "volume/store.h"

#include <fcntl.h>
#include <stdio.h>  // renameat2
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <utility>

#include "common/fault_point.h"
#include "common/fd.h"
#include "common/ids.h"
#include "volume/hash.h"
#include "volume/header.h"
#include "volume/volume.h"

namespace diaphane::volume {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "voxels.i16 is little endian");

constexpr const char* kHeaderFile = "volume.json";
constexpr const char* kVoxelFile = "voxels.i16";
constexpr const char* kTemporaryPrefix = ".tmp-";
constexpr off_t kMaxHeaderBytes = 1 << 20;

Error disk_error(const char* what) {
  const ErrorCode code =
      errno == ENOSPC || errno == EDQUOT ? ErrorCode::kTooLarge : ErrorCode::kUnavailable;
  return {code, std::string(what) + ": " + std::strerror(errno), {}};
}

Result<void> write_file(int directory, const char* name, const void* data, std::size_t bytes) {
  const Fd file(
      openat(directory, name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0640));
  if (!file || !write_all(file.get(), data, bytes) || fsync(file.get()) != 0) {
    return tl::unexpected(disk_error("a volume cannot be written"));
  }
  return {};
}

/// A regular file of `directory`; a link or anything else is refused.
Result<std::pair<int, off_t>> open_file(const std::string& directory, const char* name) {
  const Fd parent(open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!parent) return fail(ErrorCode::kNotFound, "there is no such volume");
  const int file = openat(parent.get(), name, O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
  struct stat info {};
  if (file < 0) return fail(ErrorCode::kNotFound, std::string("the volume has no ") + name);
  if (fstat(file, &info) != 0 || !S_ISREG(info.st_mode)) {
    close(file);
    return fail(ErrorCode::kInvalid, std::string(name) + " is not a regular file");
  }
  return std::pair(file, info.st_size);
}

Result<void> commit(const std::string& temporary, const std::string& directory) {
  if (renameat2(AT_FDCWD, temporary.c_str(), AT_FDCWD, directory.c_str(), RENAME_NOREPLACE) == 0) {
    return {};
  }
  if (errno == EEXIST) return fail(ErrorCode::kConflict, "this volume exists already");
  if (errno != EINVAL) return tl::unexpected(disk_error("a volume cannot be renamed"));
  // A file system without RENAME_NOREPLACE: rename(2) replaces nothing but an empty directory.
  if (fs::exists(directory)) return fail(ErrorCode::kConflict, "this volume exists already");
  if (rename(temporary.c_str(), directory.c_str()) != 0) {
    return tl::unexpected(disk_error("a volume cannot be renamed"));
  }
  return {};
}

}  // namespace

Result<Header> read_header(const std::string& directory) {
  auto opened = open_file(directory, kHeaderFile);
  if (!opened) return tl::unexpected(opened.error());
  const Fd file(opened->first);
  if (opened->second > kMaxHeaderBytes) return fail(ErrorCode::kInvalid, "volume.json is too long");
  std::string text(static_cast<std::size_t>(opened->second), '\0');
  if (!read_all(file.get(), text.data(), text.size())) {
    return fail(ErrorCode::kUnavailable, "volume.json cannot be read");
  }
  return from_json(text);
}

std::optional<std::string> stored_hash(const std::string& directory) {
  const auto header = read_header(directory);
  if (header) return header->content_hash;
  std::error_code error;
  const bool there = fs::exists(fs::path(directory) / kHeaderFile, error);
  return there || error ? std::nullopt : std::optional<std::string>("");
}

Result<Volume> read(const std::string& directory, bool verify_hash) {
  auto header = read_header(directory);
  if (!header) return tl::unexpected(header.error());
  auto opened = open_file(directory, kVoxelFile);
  if (!opened) return tl::unexpected(opened.error());
  const Fd file(opened->first);
  const std::uint64_t count = header->voxel_count();
  if (static_cast<std::uint64_t>(opened->second) != count * sizeof(std::int16_t)) {
    return fail(ErrorCode::kInvalid, "voxels.i16 has not the size that volume.json says");
  }
  Volume volume{std::move(*header), {}, {}};
  volume.id = fs::path(directory).lexically_normal().filename().string();
  try {
    volume.voxels.resize(count);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "the volume does not fit in memory");
  }
  if (!read_all(file.get(), volume.voxels.data(), count * sizeof(std::int16_t))) {
    return fail(ErrorCode::kUnavailable, "voxels.i16 cannot be read");
  }
  if (verify_hash) {
    auto hash = content_hash(volume.voxels.data(), count * sizeof(std::int16_t));
    if (!hash) return tl::unexpected(hash.error());
    if (*hash != volume.header.content_hash) {
      return fail(ErrorCode::kInternal,
                  "the voxels are not those that were stored: the disk is broken");
    }
  }
  return volume;
}

namespace {

/// A volume under a temporary name beside its place, written and synced.
class Staged {
 public:
  static Result<Staged> make(Volume& volume, const std::string& directory);
  Staged(Staged&&) = default;
  Staged& operator=(Staged&&) = delete;
  ~Staged() {
    if (inside_) erase(temporary_);
  }
  const fs::path& target() const { return target_; }
  Result<void> commit() {
    fault_point("written");
    if (auto ok = volume::commit(temporary_, target_); !ok) return ok;
    inside_.reset();
    return sync();
  }
  Result<void> exchange() {
    // Ours until it is erased below: a sweep in between would not wait until the new one is synced.
    const Fd old(open(target_.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (old) (void)flock(old.get(), LOCK_EX | LOCK_NB);
    if (renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) != 0) {
      if (errno == ENOENT) return fail(ErrorCode::kNotFound, "there is no such volume");
      return tl::unexpected(disk_error("a volume cannot be exchanged"));
    }
    // Synced before the old one goes: after a power failure there must be one of them.
    const auto synced = sync();
    inside_.reset();
    fault_point("exchanged");
    if (synced) erase(temporary_);
    return synced;
  }

 private:
  Staged(fs::path target, fs::path temporary)
      : target_(std::move(target)), temporary_(std::move(temporary)) {}

  Result<void> sync() const {
    const fs::path parent = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
    const Fd outside(open(parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!outside || fsync(outside.get()) != 0) {
      return tl::unexpected(disk_error("the volume store cannot be synced"));
    }
    return {};
  }

  fs::path target_, temporary_;
  std::unique_ptr<Fd> inside_;  ///< while it is ours to remove
};

Result<Staged> Staged::make(Volume& volume, const std::string& directory) {
  if (volume.voxels.size() != volume.header.voxel_count()) {
    return fail(ErrorCode::kInvalid, "the voxels do not fill the size");
  }
  const fs::path target = fs::path(directory).lexically_normal();
  const std::string name = target.filename().string();
  if (name.empty() || name == "." || name == ".." || name.starts_with('.')) {
    return fail(ErrorCode::kInvalid, "a volume's directory needs a plain name");
  }
  const fs::path parent = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const std::size_t bytes = volume.voxels.size() * sizeof(std::int16_t);
  auto hash = content_hash(volume.voxels.data(), bytes);
  if (!hash && hash.error().code != ErrorCode::kUnsupported) return tl::unexpected(hash.error());
  volume.header.content_hash = hash.value_or("");
  auto text = to_json(volume.header);
  if (!text) return tl::unexpected(text.error());

  Staged staged(target, parent / (kTemporaryPrefix + name + "-" + random_hex(8)));
  if (mkdir(staged.temporary_.c_str(), 0750) != 0) {
    return tl::unexpected(disk_error("the volume store cannot be written"));
  }
  // The lock says "a living writer": see sweep_unfinished. It goes with the process, however that
  // ends.
  staged.inside_ =
      std::make_unique<Fd>(open(staged.temporary_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  const int inside = staged.inside_->get();
  if (inside < 0 || flock(inside, LOCK_EX | LOCK_NB) != 0) {
    return tl::unexpected(disk_error("a volume cannot be written"));
  }
  if (auto ok = write_file(inside, kVoxelFile, volume.voxels.data(), bytes); !ok) {
    return tl::unexpected(ok.error());
  }
  if (auto ok = write_file(inside, kHeaderFile, text->data(), text->size()); !ok) {
    return tl::unexpected(ok.error());
  }
  if (fsync(inside) != 0) return tl::unexpected(disk_error("a volume cannot be synced"));
  return staged;
}

}  // namespace

void erase(const std::string& directory) {
  for (const char* name : {kVoxelFile, kHeaderFile}) {
    // Emptied first: whoever has the file open holds nothing then. A link is not followed.
    const Fd file(open((fs::path(directory) / name).c_str(), O_WRONLY | O_NOFOLLOW | O_CLOEXEC));
    if (file && ftruncate(file.get(), 0) == 0) (void)fsync(file.get());
  }
  std::error_code ignored;
  fs::remove_all(directory, ignored);
}

Result<void> write(Volume& volume, const std::string& directory) {
  if (fs::exists(fs::symlink_status(fs::path(directory).lexically_normal()))) {
    return fail(ErrorCode::kConflict, "this volume exists already");
  }
  auto staged = Staged::make(volume, directory);
  if (!staged) return tl::unexpected(staged.error());
  return staged->commit();
}

Result<void> replace(Volume& volume, const std::string& directory,
                     const std::function<Result<void>()>& about_to) {
  if (!fs::is_directory(fs::symlink_status(fs::path(directory).lexically_normal()))) {
    return fail(ErrorCode::kNotFound, "there is no such volume");
  }
  auto staged = Staged::make(volume, directory);
  if (!staged) return tl::unexpected(staged.error());
  if (auto ok = about_to(); !ok) return ok;
  return staged->exchange();
}

Result<std::size_t> sweep_unfinished(const std::string& store) {
  std::error_code error;
  std::size_t removed = 0;
  for (fs::directory_iterator entry(store, error), end; !error && entry != end;
       entry.increment(error)) {
    if (!entry->path().filename().string().starts_with(kTemporaryPrefix)) continue;
    const Fd held(open(entry->path().c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (!held || flock(held.get(), LOCK_EX | LOCK_NB) != 0) continue;
    erase(entry->path());
    if (!fs::exists(fs::symlink_status(entry->path()))) ++removed;
  }
  if (error) return fail(ErrorCode::kUnavailable, "the volume store cannot be listed");
  return removed;
}

}  // namespace diaphane::volume
