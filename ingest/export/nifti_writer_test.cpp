#include "ingest/export/nifti_writer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <span>
#include <string>

#include "ingest/build/nifti.h"

namespace diaphane::ingest {
namespace {

volume::Header small_header() {
  volume::Header header;
  header.size = {3, 4, 5};
  header.spacing = {0.5, 0.75, 2};
  header.modality = volume::Modality::kCt;
  header.origin = {{-100.25, 20.5, 300}};
  return header;
}

std::vector<std::int16_t> numbered_voxels(const volume::Header& header) {
  std::vector<std::int16_t> voxels(header.total_voxel_count());
  for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = static_cast<std::int16_t>(i * 997);
  return voxels;
}

std::string written(const volume::Header& header) {
  std::string file;
  const auto voxels = numbered_voxels(header);
  const auto done = write_nifti(header, voxels, false, [&](std::string_view bytes) -> Result<void> {
    file += bytes;
    return {};
  });
  EXPECT_TRUE(done);
  return file;
}

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

/// Clears sform_code, so that the reader uses the qform.
std::string with_qform_only(std::string file) {
  constexpr std::size_t kSformCode = 254;
  file[kSformCode] = 0;
  return file;
}

/// All rotations that map axes to axes.
std::vector<std::array<double, 9>> rotations() {
  std::vector<std::array<double, 9>> all;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      if (a == b) continue;
      for (const int signs : {0, 1, 2, 3}) {
        std::array<double, 9> m{};
        const double sa = (signs & 1) != 0 ? -1 : 1, sb = (signs & 2) != 0 ? -1 : 1;
        m[3 * a] = sa;
        m[3 * b + 1] = sb;
        // The third column is the cross product of the others.
        const std::size_t c = 3 - a - b;
        m[3 * c + 2] = sa * sb * ((a + 1) % 3 == b ? 1 : -1);
        all.push_back(m);
      }
    }
  }
  return all;
}

TEST(NiftiWriter, KeepsValuesSizeAndModality) {
  const auto header = small_header();
  const std::string file = written(header);
  const auto read = read_nifti_header(bytes_of(file));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->size, header.size);
  EXPECT_EQ(read->modality, volume::Modality::kCt);
  EXPECT_EQ(read->slope, 1);
  EXPECT_EQ(read->intercept, 0);
  const auto voxels = numbered_voxels(header);
  ASSERT_EQ(file.size() - read->voxels_begin, voxels.size() * 2);
  EXPECT_EQ(std::memcmp(file.data() + read->voxels_begin, voxels.data(), voxels.size() * 2), 0);
}

TEST(NiftiWriter, BothFormsPlaceVoxelsInEveryOrientation) {
  auto header = small_header();
  const auto all = rotations();
  ASSERT_EQ(all.size(), 24U);
  for (const auto& direction : all) {
    header.direction = direction;
    const std::string file = written(header);
    for (const std::string& one : {file, with_qform_only(file)}) {
      const auto read = read_nifti_header(bytes_of(one));
      ASSERT_TRUE(read);
      ASSERT_TRUE(read->has_axes);
      for (std::size_t i = 0; i < 9; ++i) {
        // Floats of the quaternion have a relative error of 6e-8 each.
        EXPECT_NEAR(read->axes[i], direction[i] * header.spacing[i % 3], 1e-6);
      }
      for (std::size_t i = 0; i < 3; ++i)
        EXPECT_NEAR((*read->origin)[i], (*header.origin)[i], 1e-5);
    }
  }
}

TEST(NiftiWriter, CentresScanOfUnknownPosition) {
  auto header = small_header();
  header.origin.reset();
  const auto read = read_nifti_header(bytes_of(written(header)));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->origin, (std::array<double, 3>{-0.5, -1.125, -4}));
}

TEST(NiftiWriter, WritesPhasesAsTheFourthAxis) {
  auto header = small_header();
  using volume::PhaseKind;
  header.phases = {{PhaseKind::kTime, 0}, {PhaseKind::kTime, 40}, {PhaseKind::kTime, 80}};
  const std::string file = written(header);
  const auto read = read_nifti_header(bytes_of(file));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->phases, header.phases);
  const auto voxels = read_nifti_voxels(bytes_of(file), *read);
  ASSERT_TRUE(voxels);
  EXPECT_EQ(voxels->voxels, numbered_voxels(header));
  // Uneven times and other kinds have no unit in this format.
  header.phases[1].value = 50;
  EXPECT_EQ(read_nifti_header(bytes_of(written(header)))->phases.at(1).kind, PhaseKind::kIndex);
  header.phases = {{PhaseKind::kCycle, 0}, {PhaseKind::kCycle, 50}};
  EXPECT_EQ(read_nifti_header(bytes_of(written(header)))->phases.at(1).kind, PhaseKind::kIndex);
}

TEST(NiftiWriter, RefusesAxisLongerThanTheFormatAllows) {
  auto header = small_header();
  header.size = {kMostNiftiSide + 1, 1, 1};
  const std::vector<std::int16_t> voxels(header.voxel_count());
  const auto done =
      write_nifti(header, voxels, false, [](std::string_view) -> Result<void> { return {}; });
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::kTooLarge);
}

TEST(NiftiWriter, ReturnsErrorOfSink) {
  const auto header = small_header();
  for (const bool compress : {false, true}) {
    const auto done = write_nifti(
        header, numbered_voxels(header), compress,
        [](std::string_view) -> Result<void> { return fail(ErrorCode::kUnavailable, "full"); });
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::kUnavailable);
  }
}

}  // namespace
}  // namespace diaphane::ingest
