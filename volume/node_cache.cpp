#include "volume/node_cache.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <new>
#include <utility>

#include "common/fault_point.h"
#include "common/fd.h"
#include "common/ids.h"
#include "common/try.h"
#include "volume/hash.h"
#include "volume/store.h"

namespace diaphane::volume {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSuffix = ".sealed";
constexpr const char* kRoomLock = ".room";
constexpr const char* kSweepLock = ".sweep";
constexpr std::size_t kPiece = std::size_t{1} << 20;
static_assert(kPiece % Seal::kBlock == 0);

/// Returns the file name of a copy, "<id>.<tag>.sealed".
std::string name_of(const std::string& id, const Seal& seal) {
  return id + "." + seal.tag() + kSuffix;
}

std::string id_of(const std::string& name) { return name.substr(0, name.find('.')); }

bool is_copy(const std::string& name) { return name.ends_with(kSuffix) && !name.starts_with('.'); }

std::int64_t nanoseconds(const timespec& at) { return at.tv_sec * 1'000'000'000 + at.tv_nsec; }

/// An exclusive file lock, held for the lifetime of this object. With LOCK_NB in `flags`, it does
/// not wait for another process.
class FileLock {
 public:
  FileLock(const std::string& path, int flags)
      : file_(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600)) {
    int done = -1;
    do {
      done = file_ ? flock(file_.get(), LOCK_EX | flags) : -1;
    } while (done != 0 && file_ && errno == EINTR);
    held_ = done == 0;
  }
  explicit operator bool() const { return held_; }
  int fd() const { return file_.get(); }

 private:
  Fd file_;
  bool held_ = false;
};

/// Marks the file as just used. Uses the precise clock, because timestamps that the file system
/// sets itself advance only every few milliseconds.
void mark_used(int file) {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  const timespec times[2] = {now, now};
  (void)futimens(file, times);
}

/// Truncates the file before it removes it, so that a process that has it open cannot read it any
/// more.
void erase_copy(const std::string& path) {
  const Fd file(open(path.c_str(), O_WRONLY | O_NOFOLLOW | O_CLOEXEC));
  if (file) (void)!ftruncate(file.get(), 0);
  unlink(path.c_str());
}

/// Removes a file that a killed writer left. A running writer holds a lock on its file.
void erase_unless_written(const std::string& path) {
  const Fd file(open(path.c_str(), O_WRONLY | O_NOFOLLOW | O_CLOEXEC));
  if (file && flock(file.get(), LOCK_EX | LOCK_NB) == 0) erase_copy(path);
}

std::vector<std::string> names_in(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    names.push_back(entry->path().filename().string());
  }
  return names;
}

}  // namespace

std::optional<std::vector<std::string>> make_room(std::vector<CachedCopy> copies,
                                                  std::uint64_t needed, std::uint64_t bound) {
  if (needed > bound) return std::nullopt;
  std::uint64_t bytes = needed;
  for (const CachedCopy& copy : copies) bytes += copy.bytes;
  std::sort(copies.begin(), copies.end(), [](const CachedCopy& a, const CachedCopy& b) {
    return std::pair(a.used, a.name) < std::pair(b.used, b.name);
  });
  std::vector<std::string> going;
  for (const CachedCopy& copy : copies) {
    if (bytes <= bound) break;
    // Files that are being written occupy space but must not be removed.
    if (!is_copy(copy.name)) continue;
    bytes -= copy.bytes;
    going.push_back(copy.name);
  }
  if (bytes > bound) return std::nullopt;
  return going;
}

Result<std::unique_ptr<NodeCache>> NodeCache::open(Options options) {
  DIAPHANE_TRY(Seal::of("probe"));
  std::error_code error;
  fs::create_directories(fs::path(options.folder).parent_path(), error);
  (void)mkdir(options.folder.c_str(), 0700);
  if (access(options.folder.c_str(), R_OK | W_OK | X_OK) != 0) {
    return fail(ErrorCode::kUnavailable, "the folder for volume copies is not writable");
  }
  return std::unique_ptr<NodeCache>(new NodeCache(std::move(options)));
}

NodeCache::NodeCache(Options options) : options_(std::move(options)) {
  writer_ = std::jthread([this](const std::stop_token& stop) { write_all_kept(stop); });
  if (options_.sweep_period.count() > 0) {
    sweeper_ = std::jthread([this](const std::stop_token& stop) { sweep_always(stop); });
  }
}

NodeCache::~NodeCache() = default;

Result<Volume> NodeCache::read(const std::string& id, std::uint32_t phase) {
  const std::string directory = options_.store + "/" + id;
  auto header = read_header(directory);
  DIAPHANE_TRY(header);
  if (!header->phases.empty() || phase > 0) return volume::read(directory, false, phase);
  const auto seal = Seal::of(header->content_hash);
  if (seal) {
    // Only the voxels are copied to the node, because labels are small.
    auto labels = read_labels(directory, *header);
    DIAPHANE_TRY(labels);
    auto label_set = read_label_set(directory, *header);
    DIAPHANE_TRY(label_set);
    Volume volume;
    volume.header = std::move(*header);
    volume.id = id;
    volume.labels = std::move(*labels);
    volume.label_set = std::move(*label_set);
    // Checks the hash again, because the volume may have been erased or replaced while the copy was
    // read.
    if (read_copy(name_of(id, *seal), *seal, volume.header, volume.voxels) &&
        stored_hash(directory) == volume.header.content_hash) {
      const std::lock_guard lock(mutex_);
      ++counts_.hits;
      return volume;
    }
  }
  {
    const std::lock_guard lock(mutex_);
    ++counts_.misses;
  }
  return volume::read(directory, false);
}

bool NodeCache::read_copy(const std::string& name, const Seal& seal, const Header& header,
                          std::vector<std::int16_t>& voxels) {
  const Fd file(::open(path(name).c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  if (!file) return false;
  struct stat info {};
  if (fstat(file.get(), &info) != 0 || !S_ISREG(info.st_mode)) return false;
  const std::uint64_t bytes = header.voxel_count() * sizeof(std::int16_t);
  bool intact = static_cast<std::uint64_t>(info.st_size) == bytes;
  if (intact) {
    try {
      voxels.resize(header.voxel_count());
    } catch (const std::bad_alloc&) {
      return false;  // The copy may be intact, so it stays.
    }
    RunningHash hash;
    auto* data = reinterpret_cast<char*>(voxels.data());
    for (std::uint64_t at = 0; intact && at < bytes; at += kPiece) {
      const std::size_t piece = std::min<std::uint64_t>(kPiece, bytes - at);
      intact = read_all(file.get(), data + at, piece);
      if (!intact) break;
      seal.apply(data + at, piece, at);
      hash.add(data + at, piece);
    }
    intact = intact && hash.end() == header.content_hash;
  }
  if (!intact) {
    unlink(path(name).c_str());
    voxels.clear();
    const std::lock_guard lock(mutex_);
    ++counts_.damaged;
    return false;
  }
  mark_used(file.get());
  return true;
}

bool NodeCache::misses(const Volume& volume) const {
  if (!volume.header.phases.empty()) return false;
  const auto seal = Seal::of(volume.header.content_hash);
  return seal && !volume.id.empty() && access(path(name_of(volume.id, *seal)).c_str(), F_OK) != 0;
}

void NodeCache::keep(Volume volume) {
  if (!misses(volume)) return;
  const std::lock_guard lock(mutex_);
  if (next_ || busy_) {
    ++counts_.refused;
    return;
  }
  next_ = std::move(volume);
  changed_.notify_all();
}

void NodeCache::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !next_ && !busy_; });
}

void NodeCache::write_all_kept(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return next_.has_value(); }) &&
         !stop.stop_requested()) {
    std::optional<Volume> volume = std::exchange(next_, std::nullopt);
    busy_ = true;
    lock.unlock();
    const bool kept = write_copy(*volume, stop);
    volume.reset();
    lock.lock();
    busy_ = false;
    ++(kept ? counts_.kept : counts_.refused);
    changed_.notify_all();
  }
}

std::vector<CachedCopy> NodeCache::list() const {
  std::vector<CachedCopy> copies;
  for (std::string& name : names_in(options_.folder)) {
    if (!is_copy(name) && !name.starts_with(kTemporaryPrefix)) continue;
    struct stat info {};
    if (lstat(path(name).c_str(), &info) != 0) continue;
    copies.push_back(
        {std::move(name), static_cast<std::uint64_t>(info.st_size), nanoseconds(info.st_mtim)});
  }
  return copies;
}

bool NodeCache::write_copy(const Volume& volume, const std::stop_token& stop) {
  const auto seal = Seal::of(volume.header.content_hash);
  if (!seal) return false;
  const std::string name = name_of(volume.id, *seal);
  const std::uint64_t bytes = volume.voxels.size() * sizeof(std::int16_t);
  const std::string temporary = path(kTemporaryPrefix + name + "-" + random_hex(8));
  std::optional<Fd> file;
  {
    // Reserves the space for the whole copy under the folder's lock, so that concurrent writers
    // never exceed the bound together.
    const FileLock room(path(kRoomLock), 0);
    if (!room) return false;
    if (access(path(name).c_str(), F_OK) == 0) return true;
    const auto going = make_room(list(), bytes, options_.bound);
    if (!going) return false;
    for (const std::string& old : *going) unlink(path(old).c_str());
    Fd created(
        ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600));
    if (created) {
      (void)flock(created.get(), LOCK_EX | LOCK_NB);
      if (posix_fallocate(created.get(), 0, static_cast<off_t>(bytes)) == 0) {
        file.emplace(std::move(created));
      } else {
        unlink(temporary.c_str());
      }
    }
    const std::lock_guard lock(mutex_);
    counts_.evicted += going->size();
  }
  if (!file) return false;
  RunningHash hash;
  std::vector<char> piece;
  const char* data = reinterpret_cast<const char*>(volume.voxels.data());
  bool good = true;
  for (std::uint64_t at = 0; good && at < bytes; at += kPiece) {
    piece.assign(data + at, data + std::min<std::uint64_t>(bytes, at + kPiece));
    hash.add(piece.data(), piece.size());
    seal->apply(piece.data(), piece.size(), at);
    good = !stop.stop_requested() && write_all(file->get(), piece.data(), piece.size());
  }
  fault_point("copied");
  // The hash differs if the volume was replaced while it was read, or if the disk is broken.
  good = good && hash.end() == volume.header.content_hash;
  mark_used(file->get());
  if (good) {
    // The lock is needed because a concurrent listing may miss a file that is being renamed, and
    // then its size would not be counted.
    const FileLock room(path(kRoomLock), 0);
    // The copy is not synced, because its hash reveals if a power failure truncated it.
    good = room && rename(temporary.c_str(), path(name).c_str()) == 0;
  }
  if (!good) unlink(temporary.c_str());
  return good;
}

void NodeCache::sweep_always(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  do {
    lock.unlock();
    sweep();
    lock.lock();
    changed_.wait_for(lock, stop, options_.sweep_period, [] { return false; });
  } while (!stop.stop_requested());
}

void NodeCache::sweep() {
  // If the store is not mounted, nothing is known about its volumes.
  if (std::error_code error; !fs::is_directory(options_.store, error)) return;
  const FileLock one(path(kSweepLock), LOCK_NB);
  if (!one) return;
  struct stat info {};
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  const auto period =
      std::chrono::duration_cast<std::chrono::nanoseconds>(options_.sweep_period).count();
  if (fstat(one.fd(), &info) == 0 && info.st_size > 0 &&
      std::abs(nanoseconds(now) - nanoseconds(info.st_mtim)) < period) {
    return;
  }
  (void)!pwrite(one.fd(), "1", 1, 0);
  mark_used(one.fd());
  std::uint64_t erased = 0;
  for (const std::string& name : names_in(options_.folder)) {
    if (name.starts_with(kTemporaryPrefix)) erase_unless_written(path(name));
    if (!is_copy(name)) continue;
    const std::string id = id_of(name);
    const auto stored = stored_hash(options_.store + "/" + id);
    if (!stored) continue;
    const auto seal = Seal::of(*stored);
    if (seal && name == name_of(id, *seal)) continue;
    erase_copy(path(name));
    ++erased;
  }
  const std::lock_guard lock(mutex_);
  counts_.erased += erased;
}

NodeCache::Counts NodeCache::counts() const {
  std::uint64_t bytes = 0;
  for (const CachedCopy& copy : list()) bytes += copy.bytes;
  const std::lock_guard lock(mutex_);
  Counts counts = counts_;
  counts.bytes = bytes;
  return counts;
}

}  // namespace diaphane::volume
