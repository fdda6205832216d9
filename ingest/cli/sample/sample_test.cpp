#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "ingest/build/build_volume.h"
#include "ingest/cli/sample/cranium.h"
#include "ingest/cli/sample/dicom_series.h"
#include "ingest/cli/sample/upload.h"
#include "ingest/dicom/series_writer.h"
#include "ingest/pipeline/tar_source.h"

namespace diaphane::sample {
namespace {

std::int16_t at(const volume::Volume& v, std::size_t x, std::size_t y, std::size_t z) {
  return v.voxels[x + v.header.size[0] * (y + v.header.size[1] * z)];
}

class Sample : public ::testing::Test {
 protected:
  void SetUp() override {
    auto read = read_cranium(kCraniumPath);
    if (!read && read.error().code == ErrorCode::kNotFound) GTEST_SKIP() << read.error().message;
    ASSERT_TRUE(read.has_value()) << read.error().message;
    cranium_ = std::move(*read);
  }
  Cranium cranium_;
};

TEST_F(Sample, PatientFacesForwardAndStandsUpright) {
  const volume::Volume v = upright(cranium_);
  constexpr std::int16_t kSkin = -300, kBone = 500;
  // In a slice through the orbits, the nose is the part of the head farthest to the front (low y).
  std::size_t front = 256, front_x = 0;
  for (std::size_t y = 0; y < 256 && front == 256; ++y) {
    for (std::size_t x = 100; x < 160; ++x) {
      if (at(v, x, y, 35) > kSkin) {
        front = y;
        front_x = x;
        break;
      }
    }
  }
  EXPECT_LT(front, 45u);
  EXPECT_NEAR(static_cast<double>(front_x), 128, 20) << "in the middle";
  // The head tapers to the vertex above, and continues below, where the scan ends.
  const auto head_in = [&](std::size_t z) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < 256 * 256; ++i) n += v.voxels[i + 65536 * z] > kSkin ? 1 : 0;
    return n;
  };
  EXPECT_LT(2 * head_in(107), head_in(0));
  EXPECT_LT(head_in(107), head_in(90));
  EXPECT_LT(head_in(90), head_in(60));
  EXPECT_LT(at(v, 128, 128, 60), kBone) << "inside is brain";
}

TEST_F(Sample, MappedVolumeKeepsTheOrderOfTheMatrix) {
  const volume::Volume v = mapped(cranium_);
  EXPECT_EQ(v.header.minimum, 0);
  EXPECT_EQ(v.header.maximum, 30000);
  for (const std::size_t i : {std::size_t{0}, std::size_t{3500000}, std::size_t{1234567}}) {
    const double share = std::clamp((cranium_.matrix[i] - 150) / 450.0, 0.0, 1.0);
    EXPECT_EQ(v.voxels[i], std::lround(30000 * share));
  }
}

TEST_F(Sample, BundledSeriesBuildsTheIdenticalVolume) {
  const volume::Volume wanted = upright(cranium_);
  Bundle bundle;
  std::size_t with_canary = 0;
  ASSERT_TRUE(write_series(wanted, [&](const std::string& file) {
                with_canary += file.find(dicom::kCanaryName) != std::string::npos ? 1 : 0;
                return bundle.add(file);
              }).has_value());
  EXPECT_EQ(with_canary, 108u);
  const std::string tar = bundle.finish();
  const int fd = memfd_create("bundle", MFD_CLOEXEC);
  ASSERT_EQ(write(fd, tar.data(), tar.size()), static_cast<ssize_t>(tar.size()));
  const dicom::ScanLimits limits;
  ingest::TarSource source(fd, limits.file.file_bytes);
  auto scan = dicom::scan(source, limits);
  ASSERT_TRUE(scan.has_value()) << scan.error().message;
  const dicom::Choice choice = dicom::choose(*scan);
  ASSERT_TRUE(choice.suitable) << choice.text;
  auto built = ingest::build_volume(source, *scan, choice, limits.file);
  ASSERT_TRUE(built.has_value()) << built.error().message;
  EXPECT_EQ(built->volume.voxels, wanted.voxels);
  EXPECT_EQ(built->volume.header.direction, wanted.header.direction);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(built->volume.header.spacing[i], wanted.header.spacing[i], 1e-9);
  EXPECT_TRUE(built->volume.header.repairs.empty());
  close(fd);
}

}  // namespace
}  // namespace diaphane::sample
