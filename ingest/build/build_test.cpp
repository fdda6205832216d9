#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "common/try.h"
#include "ingest/build/build_volume.h"
#include "ingest/build/read_folder.h"
#include "tests/support/ingest/test_series.h"

namespace diaphane::ingest {
namespace {

using namespace dicom::testing;
using dicom::SeriesSpec;
using dicom::SliceSpec;
namespace fs = std::filesystem;

Result<volume::Volume> built(std::vector<std::string> files) {
  MemorySource source(std::move(files));
  auto scan = dicom::scan(source, {});
  DIAPHANE_TRY(scan);
  const dicom::Choice choice = dicom::choose(*scan);
  if (!choice.suitable) return fail(ErrorCode::kInvalid, choice.text);
  auto built = build_volume(source, *scan, choice, {});
  DIAPHANE_TRY(built);
  return std::move(built->volume);
}

std::int16_t at(const volume::Volume& v, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return v.voxels[x + v.header.size[0] * (y + std::size_t{v.header.size[1]} * z)];
}

void expect_the_picture(const volume::Volume& v, const std::string& what) {
  for (std::uint32_t z = 0; z < v.header.size[2]; ++z) {
    for (std::uint32_t y = 0; y < v.header.size[1]; ++y) {
      for (std::uint32_t x = 0; x < v.header.size[0]; ++x) {
        ASSERT_EQ(at(v, x, y, z),
                  value_at(static_cast<int>(x), static_cast<int>(y), static_cast<int>(z)))
            << what << ": " << x << " " << y << " " << z;
      }
    }
  }
}

TEST(BuildVolume, PlacesEveryVoxelAsItsSliceStates) {
  // For every patient position, and rows or columns in either direction: the place of a voxel in
  // the patient, computed from the volume's header, is the place in its slice.
  const std::array<double, 6> orientations[] = {
      {1, 0, 0, 0, 1, 0},  {1, 0, 0, 0, 0, -1}, {0, 1, 0, 0, 0, -1}, {-1, 0, 0, 0, -1, 0},
      {1, 0, 0, 0, -1, 0}, {-1, 0, 0, 0, 1, 0}, {0, 0, 1, 1, 0, 0},  {0.6, 0.8, 0, -0.8, 0.6, 0}};
  for (const auto& orientation : orientations) {
    Options options = plain_ct();
    options.series.orientation = orientation;
    const auto& o = orientation;
    // Slices run against the normal, and the volume must still be right-handed.
    options.step = {-(o[1] * o[5] - o[2] * o[4]), -(o[2] * o[3] - o[0] * o[5]),
                    -(o[0] * o[4] - o[1] * o[3])};
    auto v = built(files_of(options));
    ASSERT_TRUE(v.has_value()) << v.error().message;
    const auto& d = v->header.direction;
    const double det = d[0] * (d[4] * d[8] - d[5] * d[7]) - d[1] * (d[3] * d[8] - d[5] * d[6]) +
                       d[2] * (d[3] * d[7] - d[4] * d[6]);
    EXPECT_NEAR(det, 1, 1e-9);
    std::array<double, 3> corner{};  // of voxel 0, 0, 0: the last slice written
    for (std::size_t i = 0; i < 3; ++i) corner[i] = options.origin[i] + 19 * 2 * options.step[i];
    ASSERT_TRUE(v->header.origin);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR((*v->header.origin)[i], corner[i], 1e-6);
    EXPECT_EQ(v->header.frame_of_reference, options.series.frame_of_reference_uid);
    for (const auto& [x, y, z] :
         {std::array{0, 0, 0}, std::array{5, 2, 7}, std::array{11, 9, 19}}) {
      const int slice = 19 - z;
      EXPECT_EQ(at(*v, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                   static_cast<std::uint32_t>(z)),
                value_at(x, y, slice));
      for (std::size_t i = 0; i < 3; ++i) {
        const double given =
            options.origin[i] + slice * 2 * options.step[i] + x * 0.7 * o[i] + y * 0.8 * o[3 + i];
        const double found = corner[i] + d[3 * i] * x * v->header.spacing[0] +
                             d[3 * i + 1] * y * v->header.spacing[1] +
                             d[3 * i + 2] * z * v->header.spacing[2];
        EXPECT_NEAR(found, given, 1e-6);
      }
    }
  }
}

TEST(BuildVolume, DecodesHounsfieldUnitsFromEveryTransferSyntax) {
  for (const char* uid : {"1.2.840.10008.1.2", "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.2",
                          "1.2.840.10008.1.2.1.99", "1.2.840.10008.1.2.5", "1.2.840.10008.1.2.4.70",
                          "1.2.840.10008.1.2.4.80", "1.2.840.10008.1.2.4.90"}) {
    Options options = plain_ct();
    options.rows = options.columns = 32;
    options.series.transfer_syntax = uid;
    auto v = built(files_of(options));
    ASSERT_TRUE(v.has_value()) << uid << v.error().message;
    expect_the_picture(*v, uid);
  }
  Options negative = plain_ct();
  negative.series.photometric = "MONOCHROME1";
  auto v = built(files_of(negative));
  ASSERT_TRUE(v.has_value());
  expect_the_picture(*v, "MONOCHROME1");
  EXPECT_TRUE(v->header.repairs.empty()) << "Hounsfield units mean the same however displayed";
  negative.series.modality = "MR";
  negative.series.sop_class = "1.2.840.10008.5.1.4.1.1.4";
  v = built(files_of(negative));
  ASSERT_TRUE(v.has_value());
  EXPECT_EQ(v->header.repairs,
            std::vector<std::string>{"the inverted (negative) image was converted back"});
}

TEST(BuildVolume, DecodesLossyJpegApproximately) {
  Options options = plain_ct();
  options.rows = options.columns = 32;
  options.series.transfer_syntax = "1.2.840.10008.1.2.4.51";  // JPEG, 12 bits
  try {
    auto v = built(files_of(options));
    ASSERT_TRUE(v.has_value()) << v.error().message;
    EXPECT_NEAR(at(*v, 5, 6, 7), value_at(5, 6, 7), 40);
  } catch (const std::runtime_error&) {
    GTEST_SKIP() << "this GDCM cannot write it";
  }
}

TEST(BuildVolume, ClampsHounsfieldUnitsAndReportsIt) {
  Options options = plain_ct();
  options.series.slope = 20;
  options.series.intercept = -1000;
  options.series.bits_stored = 16;
  options.series.high_bit = 15;
  options.change = [](int, SeriesSpec&, SliceSpec& slice) {
    slice.pixels[0] = 0xFF;
    slice.pixels[1] = 0xFF;
  };
  auto v = built(files_of(options));
  ASSERT_TRUE(v.has_value()) << v.error().message;
  EXPECT_EQ(at(*v, 0, 0, 0), 32767);
  EXPECT_EQ(v->header.repairs.size(), 1u);
}

TEST(BuildVolume, RefusesAScaleThatClipsManyValues) {
  Options options = plain_ct();
  options.series.slope = 900;
  options.series.intercept = 0;
  options.change = [](int, SeriesSpec&, SliceSpec& slice) {
    for (std::size_t i = 0; i < slice.pixels.size(); i += 2) {
      slice.pixels[i] = static_cast<std::uint8_t>(100);
      slice.pixels[i + 1] = 0;
    }
  };
  const auto v = built(files_of(options));
  ASSERT_FALSE(v.has_value()) << "every voxel would be 32767";
  EXPECT_EQ(v.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(v.error().message.find("scale"), std::string::npos);
}

TEST(BuildVolume, HalvesMrValuesBeyondInt16AndReportsIt) {
  Options options = plain_ct();
  options.series.sop_class = "1.2.840.10008.5.1.4.1.1.4";
  options.series.modality = "MR";
  options.series.bits_stored = 16;
  options.series.high_bit = 15;
  options.change = [](int z, SeriesSpec& series, SliceSpec& slice) {
    // Only the values of slices with different scales are converted, which can make them negative.
    series.slope = 1;
    series.intercept = z == 5 ? -101 : -100;
    for (std::size_t i = 0; i < slice.pixels.size(); i += 2) {
      const unsigned value = z == 3 && i == 0 ? 65535 : i == 4 ? 98 : 1000;
      slice.pixels[i] = static_cast<std::uint8_t>(value);
      slice.pixels[i + 1] = static_cast<std::uint8_t>(value >> 8);
    }
  };
  auto v = built(files_of(options));
  ASSERT_TRUE(v.has_value()) << v.error().message;
  EXPECT_EQ(at(*v, 0, 0, 3), (65535 - 100 - 1) / 2);
  for (const int z : {0, 3, 7}) {
    EXPECT_EQ(at(*v, 1, 0, z), 450) << "also in slices stored before the large value came";
    EXPECT_EQ(at(*v, 2, 0, z), -1) << "negative values stay negative";
  }
  EXPECT_EQ(v->header.repairs.size(), 2u);
}

TEST(BuildVolume, BrokenCompressedSliceDoesNotChangeOtherSlices) {
  Options options = plain_ct();
  options.rows = options.columns = 32;
  options.series.transfer_syntax = "1.2.840.10008.1.2.4.70";
  std::vector<std::string> files = files_of(options);
  std::string& file = files[4];
  const std::size_t scan = file.rfind("\xFF\xDA");
  ASSERT_NE(scan, std::string::npos);
  file.replace(scan + 14, 40, std::string(40, '\xFF'));
  auto v = built(files);
  if (v) {
    // Some decoders fill in missing data. Then at least the other slices are unchanged.
    EXPECT_EQ(at(*v, 3, 3, 0), value_at(3, 3, 0));
  } else {
    EXPECT_EQ(v.error().code, ErrorCode::kInvalid);
  }
}

/// Returns the files of two phases of a CT, by their trigger times. The values of the second one
/// are those of the picture plus 5.
std::vector<std::string> two_phases(Options options) {
  std::vector<std::string> files;
  for (const int phase : {1, 0}) {
    options.change = [phase](int, SeriesSpec& series, SliceSpec& slice) {
      series.intercept += 5 * phase;
      slice.extra.push_back({0x0018, 0x1060, "DS", std::to_string(40 * phase), {}});
    };
    for (std::string& file : files_of(options)) files.push_back(std::move(file));
  }
  return files;
}

TEST(BuildVolume, PlacesPhasesOneAfterTheOther) {
  Options tilted = plain_ct();
  tilted.step = {0, std::sin(0.1), std::cos(0.1)};
  for (const Options& options : {plain_ct(), tilted}) {
    std::vector<std::string> files = two_phases(options);
    auto alone =
        built({files.begin() + static_cast<std::ptrdiff_t>(files.size() / 2), files.end()});
    ASSERT_TRUE(alone.has_value()) << alone.error().message;
    auto both = built(files);
    ASSERT_TRUE(both.has_value()) << both.error().message;
    ASSERT_EQ(both->header.phases.size(), 2U);
    EXPECT_EQ(both->header.size, alone->header.size);
    EXPECT_EQ(both->header.maximum, alone->header.maximum + 5);
    const std::size_t count = alone->voxels.size();
    ASSERT_EQ(both->voxels.size(), 2 * count);
    const int air = options.step[1] > 0 ? -1024 : INT16_MIN;
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_EQ(both->voxels[i], alone->voxels[i]) << i;
      // Pixels that no slice covers stay air. Interpolation rounds, so values may differ by one.
      if (alone->voxels[i] != air)
        ASSERT_NEAR(both->voxels[count + i], alone->voxels[i] + 5, 1) << i;
    }
  }
}

TEST(BuildVolume, HeaderContainsNoPatientData) {
  Options options = plain_ct();
  options.series.with_patient = true;
  auto v = built(files_of(options));
  ASSERT_TRUE(v.has_value()) << v.error().message;
  const std::string store =
      (fs::temp_directory_path() / ("diaphane-build-" + std::to_string(getpid()))).string();
  ASSERT_TRUE(volume::write(*v, store).has_value());
  std::ifstream in(store + "/volume.json");
  const std::string json((std::istreambuf_iterator<char>(in)), {});
  fs::remove_all(store);
  EXPECT_EQ(json.find(dicom::kCanary), std::string::npos);
  EXPECT_EQ(json.find("2.25."), std::string::npos);
  EXPECT_NE(json.find("contentHash"), std::string::npos);
}

TEST(ReadFolder, ChoosesTheLargestSuitableSeries) {
  std::string folder = (fs::temp_directory_path() / "diaphane-folder-XXXXXX").string();
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  int n = 0;
  const auto put = [&](const Options& options) {
    for (const std::string& file : files_of(options)) {
      std::ofstream(folder + "/" + std::to_string(++n), std::ios::binary) << file;
    }
  };
  Options small = plain_ct();
  Options large = plain_ct();
  large.slices = 30;
  Options unsuitable = plain_ct();
  unsuitable.slices = 3;
  put(small);
  put(large);
  put(unsuitable);
  auto v = read_folder(folder);
  ASSERT_TRUE(v.has_value()) << v.error().message;
  EXPECT_EQ(v->header.size[2], 30u);
  expect_the_picture(*v, "folder");
  fs::remove_all(folder);
  EXPECT_EQ(read_folder(folder).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace diaphane::ingest
