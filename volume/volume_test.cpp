#include "volume/volume.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <thread>

#include "volume/hash.h"
#include "volume/header.h"
#include "volume/labels.h"
#include "volume/store.h"

namespace diaphane::volume {
namespace {

namespace fs = std::filesystem;

class VolumeStore : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "diaphane-volume-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    store_ = pattern;
  }
  void TearDown() override { fs::remove_all(store_); }
  std::string at(const std::string& name) const { return (store_ / name).string(); }
  std::size_t entries() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(store_), fs::directory_iterator()));
  }
  fs::path store_;
};

Volume ramp() {
  Volume volume;
  volume.header.size = {4, 3, 2};
  volume.header.spacing = {0.957031, 0.957031, 1.5};
  const double c = std::cos(0.3), s = std::sin(0.3);
  volume.header.direction = {c, -s, 0, s, c, 0, 0, 0, 1};
  volume.header.modality = Modality::kCt;
  volume.header.window_center = -18;
  volume.header.window_width = 406;
  volume.header.repairs = {"one slice was there twice"};
  volume.voxels.resize(24);
  std::iota(volume.voxels.begin(), volume.voxels.end(), std::int16_t{-12});
  measure(volume);
  return volume;
}

bool can_hash() { return content_hash("", 0).has_value(); }

TEST_F(VolumeStore, RoundTrips) {
  Volume volume = ramp();
  ASSERT_TRUE(write(volume, at("a")).has_value());
  auto again = read(at("a"), can_hash());
  ASSERT_TRUE(again.has_value()) << again.error().message;
  EXPECT_EQ(again->voxels, volume.voxels);
  EXPECT_EQ(again->header.size, volume.header.size);
  EXPECT_EQ(again->header.spacing, volume.header.spacing);
  EXPECT_EQ(again->header.direction, volume.header.direction);
  EXPECT_EQ(again->header.modality, Modality::kCt);
  EXPECT_EQ(again->header.window_width, 406);
  EXPECT_EQ(again->header.minimum, -12);
  EXPECT_EQ(again->header.maximum, 11);
  EXPECT_EQ(again->header.percentiles, volume.header.percentiles);
  EXPECT_EQ(again->header.repairs, volume.header.repairs);
  EXPECT_EQ(again->header.content_hash, volume.header.content_hash);
  EXPECT_EQ(entries(), 1u) << "nothing temporary stays";
}

Volume three_phases() {
  Volume volume = ramp();
  volume.header.phases = {{PhaseKind::kCycle, 0}, {PhaseKind::kCycle, 33}, {PhaseKind::kEcho, 2.5}};
  volume.voxels.resize(3 * 24);
  std::iota(volume.voxels.begin(), volume.voxels.end(), std::int16_t{-12});
  measure(volume);
  return volume;
}

TEST_F(VolumeStore, ReadsOnePhaseOrAllOfThem) {
  Volume volume = three_phases();
  ASSERT_TRUE(write(volume, at("a")).has_value());
  EXPECT_EQ(volume.header.maximum, 59) << "the statistics are those of all phases";
  for (std::uint32_t phase = 0; phase < 3; ++phase) {
    const auto one = read(at("a"), can_hash(), phase);
    ASSERT_TRUE(one.has_value()) << one.error().message;
    EXPECT_EQ(one->phase, phase);
    EXPECT_EQ(one->header.phases, volume.header.phases);
    ASSERT_EQ(one->voxels.size(), 24u);
    EXPECT_EQ(one->voxels.front(), -12 + 24 * static_cast<int>(phase));
    auto all = read_all_phases(at("a"), can_hash());
    ASSERT_TRUE(all.has_value()) << all.error().message;
    EXPECT_EQ(all->voxels, volume.voxels);
    ASSERT_TRUE(keep_phase(*all, phase).has_value());
    EXPECT_EQ(all->voxels, one->voxels);
  }
  const auto beyond = read(at("a"), false, 3);
  ASSERT_FALSE(beyond.has_value());
  EXPECT_EQ(beyond.error().code, ErrorCode::kInvalid);
  EXPECT_NE(beyond.error().message.find("3 phases"), std::string::npos);
  EXPECT_EQ(keep_phase(volume, 3).error().code, ErrorCode::kInvalid);
}

TEST_F(VolumeStore, VerifiesEveryPhaseWhenOneIsRead) {
  if (!can_hash()) GTEST_SKIP() << "no libsodium";
  Volume volume = three_phases();
  ASSERT_TRUE(write(volume, at("a")).has_value());
  {
    std::fstream file(at("a/voxels.i16"), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(2 * 24 * 2 + 1);
    file.put(1);
  }
  EXPECT_EQ(read(at("a"), true, 0).error().code, ErrorCode::kInternal);
  EXPECT_TRUE(read(at("a"), false, 0).has_value());
}

TEST_F(VolumeStore, RefusesImplausiblePhases) {
  Volume volume = three_phases();
  volume.voxels.resize(24);
  EXPECT_EQ(write(volume, at("a")).error().code, ErrorCode::kInvalid);
  volume.header.phases.resize(1);
  EXPECT_EQ(check(volume.header).error().field, "phases");
  volume.header.phases.resize(kMostPhases);
  EXPECT_TRUE(check(volume.header).has_value());
  volume.header.phases.resize(kMostPhases + 1);
  EXPECT_EQ(check(volume.header).error().field, "phases");
  volume.header.phases = {{PhaseKind::kTime, 0}, {PhaseKind::kTime, NAN}};
  EXPECT_EQ(check(volume.header).error().field, "phases");
  volume.header.phases.resize(2, {});
  volume.header.phases[1].value = 1;
  volume.header.size = {65535, 65535, 1};
  EXPECT_EQ(check(volume.header).error().code, ErrorCode::kTooLarge);
}

TEST_F(VolumeStore, KeepsLabelsIfThereAreAny) {
  Volume volume = ramp();
  volume.labels = encode(Labels{volume.header.size, std::vector<std::uint8_t>(24, 1)});
  ASSERT_TRUE(write(volume, at("a")).has_value());
  EXPECT_EQ(read(at("a"), can_hash())->labels, volume.labels);
  EXPECT_EQ(read_labels(at("a"), volume.header), volume.labels);
  Volume without = ramp();
  ASSERT_TRUE(replace(without, at("a"), [] { return Result<void>(); }).has_value());
  EXPECT_EQ(read_labels(at("a"), volume.header), "");
}

TEST_F(VolumeStore, RefusesLabelsLongerThanTheMaximum) {
  Volume volume = ramp();
  ASSERT_TRUE(write(volume, at("a")).has_value());
  std::ofstream(at("a") + "/labels") << std::string(most_label_bytes(volume.header) + 1, 'x');
  EXPECT_FALSE(read(at("a"), false));
}

TEST_F(VolumeStore, DetectsChangedVoxel) {
  if (!can_hash()) GTEST_SKIP() << "no libsodium";
  Volume volume = ramp();
  ASSERT_TRUE(write(volume, at("a")).has_value());
  {
    std::fstream file(at("a/voxels.i16"), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(7);
    file.put(1);
  }
  auto again = read(at("a"), true);
  ASSERT_FALSE(again.has_value());
  EXPECT_EQ(again.error().code, ErrorCode::kInternal);
}

TEST_F(VolumeStore, RefusesVoxelsThatDoNotMatchTheSize) {
  Volume volume = ramp();
  volume.voxels.pop_back();
  EXPECT_EQ(write(volume, at("a")).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(entries(), 0u);
  volume = ramp();
  ASSERT_TRUE(write(volume, at("a")).has_value());
  for (const int bytes : {0, 46, 47, 50}) {
    fs::resize_file(at("a/voxels.i16"), bytes);
    auto again = read(at("a"), false);
    ASSERT_FALSE(again.has_value()) << bytes;
    EXPECT_EQ(again.error().code, ErrorCode::kInvalid);
  }
}

TEST_F(VolumeStore, ReaderSeesWholeVolumeOrNone) {
  // A reader runs concurrently with a writer. Every volume that it can open must be complete.
  constexpr int kRounds = 40;
  Volume big = ramp();
  big.header.size = {64, 64, 64};
  big.voxels.assign(64 * 64 * 64, 5);
  measure(big);
  std::thread writer([&] {
    for (int i = 0; i < kRounds; ++i) {
      Volume copy = big;
      ASSERT_TRUE(write(copy, at("v" + std::to_string(i))).has_value());
    }
  });
  for (int i = 0; i < kRounds; ++i) {
    for (;;) {
      auto seen = read(at("v" + std::to_string(i)), can_hash());
      if (seen) break;
      EXPECT_EQ(seen.error().code, ErrorCode::kNotFound) << seen.error().message;
      EXPECT_NE(seen.error().message.find("volume does not exist"), std::string::npos);
      if (::testing::Test::HasFailure()) break;
      std::this_thread::yield();
    }
  }
  writer.join();
}

TEST_F(VolumeStore, NeverOverwritesExistingVolume) {
  Volume volume = ramp();
  ASSERT_TRUE(write(volume, at("a")).has_value());
  EXPECT_EQ(write(volume, at("a")).error().code, ErrorCode::kConflict);
  fs::create_directory(at("empty"));
  EXPECT_EQ(write(volume, at("empty")).error().code, ErrorCode::kConflict);
  EXPECT_EQ(entries(), 2u);
}

TEST_F(VolumeStore, RefusesPathWithoutPlainName) {
  Volume volume = ramp();
  for (const std::string name : {"", ".", "..", ".tmp-x", "a/.."}) {
    EXPECT_FALSE(write(volume, at(name)).has_value()) << name;
  }
  EXPECT_FALSE(write(volume, at("missing/a")).has_value());
  EXPECT_EQ(entries(), 0u);
}

TEST_F(VolumeStore, DoesNotFollowSymbolicLinks) {
  Volume volume = ramp();
  ASSERT_TRUE(write(volume, at("a")).has_value());
  fs::rename(at("a/voxels.i16"), at("elsewhere"));
  fs::create_symlink(at("elsewhere"), at("a/voxels.i16"));
  EXPECT_FALSE(read(at("a"), false).has_value());
}

TEST_F(VolumeStore, SweepRemovesUnlockedTemporaryFolders) {
  fs::create_directories(at(".tmp-dead-1234"));
  std::ofstream(at(".tmp-dead-1234/voxels.i16")) << "half";
  fs::create_directories(at(".tmp-live-1234"));
  const int held = open(at(".tmp-live-1234").c_str(), O_RDONLY | O_DIRECTORY);
  ASSERT_EQ(flock(held, LOCK_EX), 0);
  Volume volume = ramp();
  ASSERT_TRUE(write(volume, at("a")).has_value());
  EXPECT_EQ(sweep_unfinished(store_.string()).value_or(99), 1u);
  EXPECT_FALSE(fs::exists(at(".tmp-dead-1234")));
  EXPECT_TRUE(fs::exists(at(".tmp-live-1234")));
  EXPECT_TRUE(fs::exists(at("a/volume.json")));
  close(held);
  EXPECT_EQ(sweep_unfinished(store_.string()).value_or(99), 1u);
  EXPECT_FALSE(sweep_unfinished(at("missing")).has_value());
}

TEST(Measure, PercentilesUseNearestRank) {
  Volume volume;
  volume.header.size = {1000, 1, 1};
  for (int i = 1; i <= 1000; ++i) volume.voxels.push_back(static_cast<std::int16_t>(1001 - i));
  measure(volume);
  EXPECT_EQ(volume.header.minimum, 1);
  EXPECT_EQ(volume.header.maximum, 1000);
  const std::array<double, 8> expected{10, 100, 250, 500, 750, 900, 990, 999};
  EXPECT_EQ(volume.header.percentiles, expected);
}

TEST(Measure, CoversTheWholeInt16Range) {
  Volume volume;
  volume.header.size = {2, 1, 1};
  volume.voxels = {INT16_MIN, INT16_MAX};
  measure(volume);
  EXPECT_EQ(volume.header.minimum, INT16_MIN);
  EXPECT_EQ(volume.header.maximum, INT16_MAX);
}

TEST(Header, RefusesMirroringOrShearingDirections) {
  Header header = ramp().header;
  header.direction = {1, 0, 0, 0, 1, 0, 0, 0, -1};
  EXPECT_FALSE(check(header).has_value());
  header.direction = {1, 0.2, 0, 0, 1, 0, 0, 0, 1};
  EXPECT_FALSE(check(header).has_value());
  header.direction.fill(std::nan(""));
  EXPECT_FALSE(check(header).has_value());
}

TEST(Header, RefusesSizesAndSpacingsOutOfRange) {
  const Header good = ramp().header;
  Header header = good;
  header.size = {65535, 65535, 65535};
  EXPECT_EQ(check(header).error().code, ErrorCode::kTooLarge);
  header.size = {0, 1, 1};
  EXPECT_FALSE(check(header).has_value());
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    header = good;
    header.spacing[1] = bad;
    EXPECT_FALSE(check(header).has_value()) << bad;
  }
}

TEST(Header, RefusesUnknownFields) {
  // The header is an allow-list, so text with an unknown field, such as a patient's name, is
  // refused.
  std::string text = *to_json(ramp().header);
  EXPECT_TRUE(from_json(text).has_value());
  text.insert(text.find('{') + 1, "\"patientName\": \"x\",");
  EXPECT_FALSE(from_json(text).has_value());
  for (const char* other : {"", "{}", "[]", "{\"format\":2}", "{\"format\":1}", "not JSON"}) {
    EXPECT_FALSE(from_json(other).has_value()) << other;
  }
}

}  // namespace
}  // namespace diaphane::volume
