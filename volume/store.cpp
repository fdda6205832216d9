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
#include "common/try.h"
#include "volume/hash.h"
#include "volume/header.h"
#include "volume/labels.h"
#include "volume/volume.h"

namespace diaphane::volume {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "voxels.i16 is little endian");

constexpr const char* kHeaderFile = "volume.json";
constexpr const char* kVoxelFile = "voxels.i16";
constexpr const char* kLabelFile = "labels";
constexpr const char* kLabelSetFile = "label_set";
// Temporary names: a new header or label set is written completely, then renamed over the old one.
constexpr const char* kNewHeaderFile = ".volume.json.new";
constexpr const char* kNewLabelSetFile = ".label_set.new";
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
    return tl::unexpected(disk_error("cannot write a volume"));
  }
  return {};
}

/// Opens a regular file of `directory`. Refuses links and other types of files.
Result<std::pair<int, off_t>> open_file(const std::string& directory, const char* name) {
  const Fd parent(open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!parent) return fail(ErrorCode::kNotFound, "the volume does not exist");
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
  if (errno == EEXIST) return fail(ErrorCode::kConflict, "the volume already exists");
  if (errno != EINVAL) return tl::unexpected(disk_error("cannot rename a volume"));
  // The file system does not support RENAME_NOREPLACE. rename(2) replaces only an empty directory.
  if (fs::exists(directory)) return fail(ErrorCode::kConflict, "the volume already exists");
  if (rename(temporary.c_str(), directory.c_str()) != 0) {
    return tl::unexpected(disk_error("cannot rename a volume"));
  }
  return {};
}

}  // namespace

Result<Header> read_header(const std::string& directory) {
  auto opened = open_file(directory, kHeaderFile);
  DIAPHANE_TRY(opened);
  const Fd file(opened->first);
  if (opened->second > kMaxHeaderBytes) return fail(ErrorCode::kInvalid, "volume.json is too long");
  std::string text(static_cast<std::size_t>(opened->second), '\0');
  if (!read_all(file.get(), text.data(), text.size())) {
    return fail(ErrorCode::kUnavailable, "cannot read volume.json");
  }
  return from_json(text);
}

std::string version_of(const Header& header) {
  return header.label_hash.empty() ? header.content_hash
                                   : header.content_hash + " " + header.label_hash;
}

std::optional<std::string> stored_hash(const std::string& directory) {
  auto version = stored_version(directory);
  if (version) version->resize(std::min(version->find(' '), version->size()));
  return version;
}

std::optional<std::string> stored_version(const std::string& directory) {
  const auto header = read_header(directory);
  if (header) return version_of(*header);
  std::error_code error;
  const bool has_header = fs::exists(fs::path(directory) / kHeaderFile, error);
  return has_header || error ? std::nullopt : std::optional<std::string>("");
}

Result<std::string> read_labels(const std::string& directory, const Header& header) {
  auto opened = open_file(directory, kLabelFile);
  if (!opened && opened.error().code == ErrorCode::kNotFound) return std::string();
  DIAPHANE_TRY(opened);
  const Fd file(opened->first);
  if (static_cast<std::uint64_t>(opened->second) > most_label_bytes(header)) {
    return fail(ErrorCode::kInvalid, "the labels are too long");
  }
  std::string labels(static_cast<std::size_t>(opened->second), '\0');
  if (!read_all(file.get(), labels.data(), labels.size())) {
    return fail(ErrorCode::kUnavailable, "cannot read the labels");
  }
  return labels;
}

Result<LabelSet> read_label_set(const std::string& directory, const Header& header) {
  if (header.label_hash.empty()) return LabelSet{};
  auto opened = open_file(directory, kLabelSetFile);
  DIAPHANE_TRY(opened);
  const Fd file(opened->first);
  if (static_cast<std::uint64_t>(opened->second) > most_label_set_bytes(header)) {
    return fail(ErrorCode::kInvalid, "the label set is too long");
  }
  try {
    std::string bytes(static_cast<std::size_t>(opened->second), '\0');
    if (!read_all(file.get(), bytes.data(), bytes.size())) {
      return fail(ErrorCode::kUnavailable, "cannot read the label set");
    }
    return decode_label_set(bytes, header.size);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "the labels do not fit in memory");
  }
}

Result<void> check_phase(const Header& header, std::uint32_t phase) {
  if (phase < header.phase_count()) return {};
  const std::string count = std::to_string(header.phase_count());
  return fail(ErrorCode::kInvalid,
              header.phases.empty()
                  ? "this scan has no phases"
                  : "this scan has " + count + " phases, and they are counted from 0",
              "phase");
}

namespace {

/// Compares the checksum of the whole voxel file with the header.
Result<void> verify_voxels(int file, const Header& header) {
  DIAPHANE_TRY(content_hash(nullptr, 0));  // initialises the library, or returns kUnsupported
  std::vector<char> piece(std::size_t{1} << 20);
  RunningHash hash;
  const std::uint64_t bytes = header.total_voxel_count() * sizeof(std::int16_t);
  for (std::uint64_t at = 0; at < bytes; at += piece.size()) {
    piece.resize(std::min<std::uint64_t>(piece.size(), bytes - at));
    if (!read_all_at(file, at, piece.data(), piece.size())) {
      return fail(ErrorCode::kUnavailable, "cannot read voxels.i16");
    }
    hash.add(piece.data(), piece.size());
  }
  if (hash.end() == header.content_hash) return {};
  return fail(ErrorCode::kInternal,
              "the voxels do not match their stored checksum; the disk may be failing");
}

/// Reads `phases` phases from the phase `first` on.
Result<Volume> read_phases(const std::string& directory, bool verify_hash, Header header,
                           std::uint32_t first, std::uint32_t phases) {
  auto opened = open_file(directory, kVoxelFile);
  DIAPHANE_TRY(opened);
  const Fd file(opened->first);
  if (static_cast<std::uint64_t>(opened->second) !=
      header.total_voxel_count() * sizeof(std::int16_t)) {
    return fail(ErrorCode::kInvalid, "the size of voxels.i16 does not match volume.json");
  }
  auto labels = read_labels(directory, header);
  DIAPHANE_TRY(labels);
  auto label_set = read_label_set(directory, header);
  DIAPHANE_TRY(label_set);
  Volume volume;
  volume.header = std::move(header);
  volume.phase = first;
  volume.labels = std::move(*labels);
  volume.label_set = std::move(*label_set);
  volume.id = fs::path(directory).lexically_normal().filename().string();
  const std::uint64_t count = volume.header.voxel_count();
  try {
    volume.voxels.resize(count * phases);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "the volume does not fit in memory");
  }
  if (!read_all_at(file.get(), count * first * sizeof(std::int16_t), volume.voxels.data(),
                   volume.voxels.size() * sizeof(std::int16_t))) {
    return fail(ErrorCode::kUnavailable, "cannot read voxels.i16");
  }
  if (verify_hash) DIAPHANE_TRY(verify_voxels(file.get(), volume.header));
  return volume;
}

}  // namespace

Result<Volume> read(const std::string& directory, bool verify_hash, std::uint32_t phase) {
  auto header = read_header(directory);
  DIAPHANE_TRY(header);
  DIAPHANE_TRY(check_phase(*header, phase));
  return read_phases(directory, verify_hash, *std::move(header), phase, 1);
}

Result<Volume> read_all_phases(const std::string& directory, bool verify_hash) {
  auto header = read_header(directory);
  DIAPHANE_TRY(header);
  const std::uint32_t phases = header->phase_count();
  return read_phases(directory, verify_hash, *std::move(header), 0, phases);
}

Result<void> keep_phase(Volume& volume, std::uint32_t phase) {
  DIAPHANE_TRY(check_phase(volume.header, phase));
  const std::uint64_t count = volume.header.voxel_count();
  if (volume.voxels.size() != volume.header.total_voxel_count()) {
    return fail(ErrorCode::kInvalid, "the volume does not hold all of its phases");
  }
  const auto begin = volume.voxels.begin() + static_cast<std::ptrdiff_t>(count * phase);
  std::move(begin, begin + static_cast<std::ptrdiff_t>(count), volume.voxels.begin());
  volume.voxels.resize(count);
  volume.voxels.shrink_to_fit();
  volume.phase = phase;
  return {};
}

namespace {

/// A complete, synced volume under a temporary name next to its final place.
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
    // Locks the old volume until it is erased below, so that a concurrent sweep does not erase it
    // before the new one is synced.
    const Fd old(open(target_.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (old) (void)flock(old.get(), LOCK_EX | LOCK_NB);
    if (renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) != 0) {
      if (errno == ENOENT) return fail(ErrorCode::kNotFound, "the volume does not exist");
      return tl::unexpected(disk_error("cannot replace a volume"));
    }
    // Syncs before the old volume is erased, so that one of them survives a power failure.
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
      return tl::unexpected(disk_error("cannot sync the volume store"));
    }
    return {};
  }

  fs::path target_, temporary_;
  std::unique_ptr<Fd> inside_;  ///< held while this object must remove the directory
};

Result<Staged> Staged::make(Volume& volume, const std::string& directory) {
  if (volume.voxels.size() != volume.header.total_voxel_count()) {
    return fail(ErrorCode::kInvalid, "the number of voxels does not match the size");
  }
  const fs::path target = fs::path(directory).lexically_normal();
  const std::string name = target.filename().string();
  if (name.empty() || name == "." || name == ".." || name.starts_with('.')) {
    return fail(ErrorCode::kInvalid, "the directory name of a volume is invalid");
  }
  const fs::path parent = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const std::size_t bytes = volume.voxels.size() * sizeof(std::int16_t);
  auto hash = content_hash(volume.voxels.data(), bytes);
  if (!hash && hash.error().code != ErrorCode::kUnsupported) return tl::unexpected(hash.error());
  volume.header.content_hash = hash.value_or("");
  volume.header.label_hash.clear();  // labels are added with write_label_set()
  auto text = to_json(volume.header);
  DIAPHANE_TRY(text);

  Staged staged(target, parent / (kTemporaryPrefix + name + "-" + random_hex(8)));
  if (mkdir(staged.temporary_.c_str(), 0750) != 0) {
    return tl::unexpected(disk_error("the volume store is not writable"));
  }
  // The lock marks the directory as in use (see sweep_unfinished). The kernel releases it when the
  // process ends for any reason.
  staged.inside_ =
      std::make_unique<Fd>(open(staged.temporary_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  const int inside = staged.inside_->get();
  if (inside < 0 || flock(inside, LOCK_EX | LOCK_NB) != 0) {
    return tl::unexpected(disk_error("cannot write a volume"));
  }
  DIAPHANE_TRY(write_file(inside, kVoxelFile, volume.voxels.data(), bytes));
  DIAPHANE_TRY(write_file(inside, kHeaderFile, text->data(), text->size()));
  if (!volume.labels.empty()) {
    DIAPHANE_TRY(write_file(inside, kLabelFile, volume.labels.data(), volume.labels.size()));
  }
  if (fsync(inside) != 0) return tl::unexpected(disk_error("cannot sync a volume"));
  return staged;
}

}  // namespace

namespace {

/// Truncates a file before it is removed, so that a process that has it open can no longer read it.
/// Links are not followed.
void truncate_file(const std::string& directory, const char* name) {
  const Fd file(open((fs::path(directory) / name).c_str(), O_WRONLY | O_NOFOLLOW | O_CLOEXEC));
  if (file && ftruncate(file.get(), 0) == 0) (void)fsync(file.get());
}

/// Replaces a file in one step. `new_name` may be left by a process that was killed.
Result<void> replace_file(int directory, const char* new_name, const char* name,
                          const std::string& bytes) {
  (void)unlinkat(directory, new_name, 0);
  DIAPHANE_TRY(write_file(directory, new_name, bytes.data(), bytes.size()));
  if (renameat(directory, new_name, directory, name) != 0) {
    return tl::unexpected(disk_error("cannot replace a file of a volume"));
  }
  return {};
}

/// Opens a volume's directory to change its files.
Result<int> open_directory(const std::string& directory) {
  const int inside = open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (inside < 0) return fail(ErrorCode::kNotFound, "the volume does not exist");
  return inside;
}

Result<void> replace_header(int directory, const Header& header) {
  auto text = to_json(header);
  DIAPHANE_TRY(text);
  DIAPHANE_TRY(replace_file(directory, kNewHeaderFile, kHeaderFile, *text));
  if (fsync(directory) != 0) return tl::unexpected(disk_error("cannot sync a volume"));
  return {};
}

}  // namespace

Result<void> write_label_set(const std::string& encoded, const std::string& directory) {
  auto header = read_header(directory);
  DIAPHANE_TRY(header);
  auto hash = content_hash(encoded.data(), encoded.size());
  DIAPHANE_TRY(hash);
  const auto opened = open_directory(directory);
  DIAPHANE_TRY(opened);
  const Fd inside(*opened);
  DIAPHANE_TRY(replace_file(inside.get(), kNewLabelSetFile, kLabelSetFile, encoded));
  header->label_hash = *hash;
  return replace_header(inside.get(), *header);
}

Result<void> remove_label_set(const std::string& directory) {
  auto header = read_header(directory);
  if (!header && header.error().code == ErrorCode::kNotFound) return {};
  DIAPHANE_TRY(header);
  const auto opened = open_directory(directory);
  DIAPHANE_TRY(opened);
  const Fd inside(*opened);
  if (!header->label_hash.empty()) {
    header->label_hash.clear();
    DIAPHANE_TRY(replace_header(inside.get(), *header));
  }
  truncate_file(directory, kLabelSetFile);
  (void)unlinkat(inside.get(), kLabelSetFile, 0);
  return {};
}

void erase(const std::string& directory) {
  for (const char* name :
       {kVoxelFile, kHeaderFile, kLabelFile, kLabelSetFile, kNewHeaderFile, kNewLabelSetFile}) {
    truncate_file(directory, name);
  }
  std::error_code ignored;
  fs::remove_all(directory, ignored);
}

Result<void> write(Volume& volume, const std::string& directory) {
  if (fs::exists(fs::symlink_status(fs::path(directory).lexically_normal()))) {
    return fail(ErrorCode::kConflict, "the volume already exists");
  }
  auto staged = Staged::make(volume, directory);
  DIAPHANE_TRY(staged);
  return staged->commit();
}

Result<void> replace(Volume& volume, const std::string& directory,
                     const std::function<Result<void>()>& about_to) {
  if (!fs::is_directory(fs::symlink_status(fs::path(directory).lexically_normal()))) {
    return fail(ErrorCode::kNotFound, "the volume does not exist");
  }
  auto staged = Staged::make(volume, directory);
  DIAPHANE_TRY(staged);
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
  if (error) return fail(ErrorCode::kUnavailable, "cannot list the volume store");
  return removed;
}

}  // namespace diaphane::volume
