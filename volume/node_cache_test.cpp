#include "volume/node_cache.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "volume/hash.h"
#include "volume/header.h"
#include "volume/store.h"

namespace diaphane::volume {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kSide = 40;
constexpr std::uint64_t kBytes = std::uint64_t{kSide} * kSide * kSide * sizeof(std::int16_t);

Volume noise(unsigned seed) {
  Volume volume;
  volume.header.size = {kSide, kSide, kSide};
  volume.voxels.resize(volume.header.voxel_count());
  std::minstd_rand draw(seed + 1);
  for (auto& voxel : volume.voxels) voxel = static_cast<std::int16_t>(draw());
  measure(volume);
  return volume;
}

class NodeCacheTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!content_hash("", 0)) GTEST_SKIP() << "a build without libsodium";
    std::string pattern = (fs::temp_directory_path() / "diaphane-copies-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    root_ = pattern;
    fs::create_directory(root_ / "store");
  }
  void TearDown() override {
    if (!root_.empty()) fs::remove_all(root_);
  }
  std::string place(const std::string& id) const { return (root_ / "store" / id).string(); }
  void store(const std::string& id, unsigned seed) const {
    Volume volume = noise(seed);
    ASSERT_TRUE(write(volume, place(id)).has_value());
  }
  std::unique_ptr<NodeCache> cache(std::uint64_t bound = 10 * kBytes) const {
    auto opened = NodeCache::open({.folder = (root_ / "copies").string(),
                                   .bound = bound,
                                   .store = (root_ / "store").string(),
                                   .sweep_period = std::chrono::milliseconds(0)});
    return opened ? std::move(*opened) : nullptr;
  }
  /// Reads and then keeps a volume, as renderd does.
  static std::vector<std::int16_t> used(NodeCache& cache, const std::string& id) {
    auto volume = cache.read(id);
    if (!volume) return {};
    auto voxels = volume->voxels;
    cache.keep(std::move(*volume));
    cache.wait();
    return voxels;
  }
  std::vector<fs::path> copies() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(root_ / "copies")) {
      const std::string name = entry.path().filename();
      if (!name.starts_with('.') || name.starts_with(".tmp-")) found.push_back(entry.path());
    }
    return found;
  }
  /// Counts bytes under the folder's lock, as a writer does. Without the lock, a listing could
  /// contain both a new file and the file that was evicted for it.
  std::uint64_t bytes_under_lock() const {
    const int room = open((root_ / "copies" / ".room").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    EXPECT_EQ(flock(room, LOCK_EX), 0);
    std::uint64_t bytes = 0;
    for (const auto& copy : copies()) {
      std::error_code gone;  // deleted or renamed in the meantime
      const auto size = fs::file_size(copy, gone);
      if (!gone) bytes += size;
    }
    close(room);
    return bytes;
  }
  static std::string bytes_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  fs::path root_;
};

TEST_F(NodeCacheTest, LaterProcessReadsVolumeFromTheCopy) {
  store("a", 1);
  EXPECT_EQ(used(*cache(), "a"), noise(1).voxels);
  const auto later = cache();
  // The voxels in the store are gone, so the volume can only come from the copy.
  fs::remove(place("a") + "/voxels.i16");
  const auto volume = later->read("a");
  ASSERT_TRUE(volume.has_value());
  EXPECT_EQ(volume->voxels, noise(1).voxels);
  EXPECT_EQ(volume->id, "a");
  EXPECT_EQ(volume->header.size[0], kSide);
  EXPECT_EQ(later->counts().hits, 1U);
  EXPECT_EQ(later->counts().bytes, kBytes);
}

TEST_F(NodeCacheTest, RemovesDamagedCopyAndReadsTheStore) {
  store("a", 1);
  const auto cache = this->cache();
  for (const bool cut : {false, true}) {
    used(*cache, "a");
    ASSERT_EQ(copies().size(), 1U);
    if (cut) {
      fs::resize_file(copies()[0], kBytes - 2);
    } else {
      const int file = open(copies()[0].c_str(), O_WRONLY);
      ASSERT_EQ(pwrite(file, "\x55", 1, kBytes / 2), 1);
      close(file);
    }
    EXPECT_EQ(cache->read("a")->voxels, noise(1).voxels);
    EXPECT_TRUE(copies().empty());
  }
  EXPECT_EQ(cache->counts().damaged, 2U);
  EXPECT_EQ(cache->counts().hits, 0U);
}

TEST_F(NodeCacheTest, TreatsCopyThatDoesNotFitInMemoryAsMiss) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers have their own operator new";
#endif
  store("a", 1);
  used(*cache(), "a");
  ASSERT_EQ(copies().size(), 1U);
  // The volume claims 2 GiB. The files are sparse, and a child process has less address space.
  Header header = read_header(place("a")).value();
  header.size = {1024, 1024, 1024};
  const std::uint64_t bytes = header.voxel_count() * sizeof(std::int16_t);
  std::ofstream(place("a") + "/volume.json") << to_json(header).value();
  fs::resize_file(place("a") + "/voxels.i16", bytes);
  fs::resize_file(copies()[0], bytes);
  const pid_t child = fork();
  if (child == 0) {
    const rlimit small{1 << 30, 1 << 30};
    setrlimit(RLIMIT_AS, &small);
    const auto mine = this->cache();
    try {
      const auto volume = mine->read("a");
      const bool good = !volume && volume.error().code == ErrorCode::kOutOfMemory &&
                        mine->counts().misses == 1 && mine->counts().damaged == 0;
      _exit(good ? 0 : 1);
    } catch (const std::bad_alloc&) {
      _exit(2);
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(copies().size(), 1U) << "nothing is wrong with it";
}

TEST_F(NodeCacheTest, ErasedVolumeIsNotFoundAndSweepRemovesItsCopy) {
  store("a", 1);
  store("b", 2);
  const auto cache = this->cache();
  used(*cache, "a");
  used(*cache, "b");
  erase(place("a"));
  EXPECT_EQ(cache->read("a").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(copies().size(), 2U);
  cache->sweep();
  ASSERT_EQ(copies().size(), 1U);
  EXPECT_TRUE(copies()[0].filename().string().starts_with("b."));
  EXPECT_EQ(cache->counts().erased, 1U);
}

TEST_F(NodeCacheTest, ReadsReplacedVolumeAndSweepRemovesTheOldCopy) {
  store("a", 1);
  const auto cache = this->cache();
  used(*cache, "a");
  const int held = open(copies()[0].c_str(), O_RDONLY);
  Volume cut = noise(2);
  ASSERT_TRUE(replace(cut, place("a"), [] { return Result<void>(); }).has_value());
  EXPECT_EQ(used(*cache, "a"), noise(2).voxels);
  EXPECT_EQ(copies().size(), 2U);
  cache->sweep();
  EXPECT_EQ(copies().size(), 1U);
  char byte = 0;
  EXPECT_EQ(pread(held, &byte, 1, 0), 0) << "who had the old copy open reads its end at once";
  close(held);
  EXPECT_EQ(used(*cache, "a"), noise(2).voxels);
  EXPECT_EQ(cache->counts().hits, 1U);
}

TEST_F(NodeCacheTest, CopyIsUnreadableWithoutTheHeaderInTheStore) {
  Volume flat = noise(1);
  std::fill(flat.voxels.begin(), flat.voxels.end(), std::int16_t{0x4141});
  measure(flat);
  ASSERT_TRUE(write(flat, place("a")).has_value());
  const auto cache = this->cache();
  EXPECT_EQ(used(*cache, "a"), flat.voxels);
  const std::string copy = bytes_of(copies()[0]);
  ASSERT_EQ(copy.size(), kBytes);
  EXPECT_EQ(copy.find("AAAA"), std::string::npos);
  const std::string hash = flat.header.content_hash.substr(flat.header.content_hash.find(':') + 1);
  EXPECT_EQ(copies()[0].filename().string().find(hash.substr(0, 8)), std::string::npos);
  // The bytes reveal nothing about the content either: all 256 values are equally frequent. For
  // 128000 bytes, chi-squared with 255 degrees of freedom exceeds 367 only once in 200000.
  std::array<double, 256> count{};
  for (const char byte : copy) ++count[static_cast<unsigned char>(byte)];
  double chi = 0;
  for (const double seen : count) chi += (seen - 500) * (seen - 500) / 500;
  EXPECT_LT(chi, 367);
}

TEST_F(NodeCacheTest, EvictsLeastRecentlyUsedOverTheLimit) {
  for (const char* id : {"a", "b", "c"}) store(id, static_cast<unsigned>(id[0]));
  const auto cache = this->cache(2 * kBytes);
  used(*cache, "a");
  used(*cache, "b");
  ASSERT_TRUE(cache->read("a").has_value());  // a is now used more recently than b
  used(*cache, "c");
  EXPECT_EQ(copies().size(), 2U);
  for (const auto& copy : copies()) EXPECT_NE(copy.filename().string()[0], 'b');
  EXPECT_EQ(cache->counts().evicted, 1U);
  const auto small = this->cache(kBytes - 1);
  EXPECT_EQ(used(*small, "b"), noise('b').voxels) << "a volume too large to keep is read";
  EXPECT_EQ(small->counts().refused, 1U);
}

TEST(MakeRoom, EvictsOldestCopiesButNoUnfinishedOnes) {
  const std::vector<CachedCopy> copies = {
      {"new.sealed", 10, 9}, {"old.sealed", 10, 1}, {".tmp-x", 10, 0}};
  EXPECT_EQ(make_room(copies, 10, 40), std::vector<std::string>{});
  EXPECT_EQ(make_room(copies, 10, 30), std::vector<std::string>{"old.sealed"});
  EXPECT_EQ(make_room(copies, 20, 30), (std::vector<std::string>{"old.sealed", "new.sealed"}));
  EXPECT_EQ(make_room(copies, 25, 30), std::nullopt);
  EXPECT_EQ(make_room({}, 31, 30), std::nullopt);
}

TEST_F(NodeCacheTest, SweepRemovesOnlyFilesOfDeadWriters) {
  const auto cache = this->cache();
  const std::string left = (root_ / "copies" / ".tmp-left").string();
  const std::string mine = (root_ / "copies" / ".tmp-mine").string();
  close(open(left.c_str(), O_WRONLY | O_CREAT, 0600));
  const int held = open(mine.c_str(), O_WRONLY | O_CREAT, 0600);
  ASSERT_EQ(flock(held, LOCK_EX | LOCK_NB), 0);
  cache->sweep();
  EXPECT_EQ(copies(), std::vector<fs::path>{mine});
  close(held);
}

TEST_F(NodeCacheTest, ReadSucceedsOnFullDisk) {
  store("a", 1);
  const auto cache = this->cache();
  // Uses a child process with a file size limit, which resembles a full disk without needing one.
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{kBytes / 2, kBytes / 2};
    setrlimit(RLIMIT_FSIZE, &small);
    const auto mine = this->cache();
    const bool good = used(*mine, "a") == noise(1).voxels && mine->counts().refused == 1;
    _exit(good ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(copies().empty());
  fs::remove_all(root_ / "copies");
  EXPECT_EQ(used(*cache, "a"), noise(1).voxels) << "the folder went";
}

TEST_F(NodeCacheTest, ProcessesShareAFolderEvenIfOneIsKilled) {
  constexpr int kVolumes = 6;
  for (int i = 0; i < kVolumes; ++i) store(std::to_string(i), static_cast<unsigned>(i));
  constexpr std::uint64_t kBound = 3 * kBytes;
  std::vector<pid_t> children;
  for (int child = 0; child < 3; ++child) {
    const pid_t pid = fork();
    if (pid == 0) {
      const auto mine = cache(kBound);
      std::minstd_rand draw(static_cast<unsigned>(child + 7));
      // The first child runs until it is killed, most likely while it writes.
      for (int turn = 0; child == 0 || turn < 150; ++turn) {
        const int which = static_cast<int>(draw() % kVolumes);
        if (used(*mine, std::to_string(which)) != noise(static_cast<unsigned>(which)).voxels)
          _exit(1);
        if (bytes_under_lock() > kBound) _exit(2);
        if (turn % 10 == 0) mine->sweep();
      }
      _exit(mine->counts().hits > 0 && mine->counts().evicted > 0 && mine->counts().damaged == 0
                ? 0
                : 3);
    }
    children.push_back(pid);
  }
  int status = 0;
  waitpid(children[1], &status, 0);
  EXPECT_EQ(status, 0);
  kill(children[0], SIGKILL);
  waitpid(children[0], &status, 0);
  waitpid(children[2], &status, 0);
  EXPECT_EQ(status, 0);
  const auto last = cache(kBound);
  last->sweep();
  for (const auto& copy : copies()) EXPECT_FALSE(copy.filename().string().starts_with('.')) << copy;
  for (int i = 0; i < kVolumes; ++i)
    EXPECT_EQ(used(*last, std::to_string(i)), noise(static_cast<unsigned>(i)).voxels);
}

}  // namespace
}  // namespace diaphane::volume
