// The table of cases of the ingest design ("Cases and the right result"), each with generated
// files.
#include "ingest/dicom/scan.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/ingest/test_series.h"

namespace diaphane::dicom {
namespace {

using namespace testing;

const Assessment& only(const Scan& scan) {
  EXPECT_EQ(scan.series.size(), 1u);
  static const Assessment nothing;
  return scan.series.empty() ? nothing : scan.series[0].assessment;
}

std::string code_of(const Options& options) {
  const Scan scan = scan_of(files_of(options));
  const Choice choice = choose(scan);
  EXPECT_FALSE(choice.suitable);
  EXPECT_FALSE(choice.text.empty());
  EXPECT_EQ(choice.text.back(), '.');
  return choice.code;
}

TEST(Case1, AcceptsRegularCt) {
  const Scan scan = scan_of(files_of(plain_ct()));
  const Assessment& a = only(scan);
  ASSERT_TRUE(a.suitable) << a.text;
  EXPECT_EQ(a.modality, volume::Modality::kCt);
  EXPECT_EQ(a.size, (std::array<std::uint32_t, 3>{12, 10, 20}));
  EXPECT_NEAR(a.spacing[0], 0.7, 1e-9) << "between columns";
  EXPECT_NEAR(a.spacing[1], 0.8, 1e-9) << "between rows";
  EXPECT_NEAR(a.spacing[2], 2, 1e-9);
  EXPECT_EQ(a.direction, (std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1}));
  EXPECT_EQ(a.window_width, 400);
  EXPECT_TRUE(a.repairs.empty());
  EXPECT_EQ(plane_name(a.direction), "axial");
}

TEST(Case1, AcceptsMrAndPet) {
  Options options = plain_ct();
  options.series.sop_class = "1.2.840.10008.5.1.4.1.1.4";
  options.series.modality = "MR";
  EXPECT_EQ(only(scan_of(files_of(options))).modality, volume::Modality::kMr);
  options.series.sop_class = "1.2.840.10008.5.1.4.1.1.128";
  options.series.modality = "PT";
  EXPECT_EQ(only(scan_of(files_of(options))).modality, volume::Modality::kPt);
}

TEST(Case2, AcceptsJitterAndReportsIt) {
  Options options = plain_ct();
  options.place = [](int z) { return 2.0 * z + (z % 2 == 1 && z < 19 ? 0.035 : 0); };
  const Scan scan = scan_of(files_of(options));
  const Assessment& a = only(scan);
  ASSERT_TRUE(a.suitable) << a.text;
  EXPECT_NEAR(a.spacing[2], 2, 1e-9);
  EXPECT_EQ(a.repairs.size(), 1u);
}

TEST(Case3, KeepsDirectionOfObliqueSlices) {
  Options options = plain_ct();
  const double c = std::cos(0.4), s = std::sin(0.4);
  options.series.orientation = {c, s, 0, 0, 0, -1};
  options.step = {-s, c, 0};  // row x column
  const Scan scan = scan_of(files_of(options));
  const Assessment& a = only(scan);
  ASSERT_TRUE(a.suitable) << a.text;
  const std::array<double, 9> expected{c, 0, -s, s, 0, c, 0, -1, 0};
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(a.direction[i], expected[i], 1e-6) << i;
}

TEST(Case4, CorrectsGantryTilt) {
  Options options = plain_ct();
  options.step = {0, std::tan(18.5 * M_PI / 180), 1};
  const Scan scan = scan_of(files_of(options));
  const Assessment& a = only(scan);
  ASSERT_TRUE(a.suitable) << a.text;
  ASSERT_EQ(a.repairs.size(), 1u);
  EXPECT_NE(a.repairs[0].find("gantry tilt of 18.5 degrees"), std::string::npos);
  // 19 distances of 2 mm shift by 12.7 mm: 15.9 rows of 0.8 mm.
  EXPECT_EQ(a.size, (std::array<std::uint32_t, 3>{12, 10 + 16, 20}));
}

TEST(Case5, FillsFewMissingSlices) {
  Options options = plain_ct();
  options.slices = 38;
  options.place = [](int z) { return 2.0 * (z < 9 ? z : z + 2); };
  const Scan scan = scan_of(files_of(options));
  const Assessment& a = only(scan);
  ASSERT_TRUE(a.suitable) << a.text;
  EXPECT_EQ(a.size[2], 40u);
  ASSERT_EQ(a.repairs.size(), 1u);
  EXPECT_NE(a.repairs[0].find("2 slices were missing"), std::string::npos);
}

TEST(Case5, RefusesManyMissingSlicesWithTheirNumber) {
  Options options = plain_ct();
  options.place = [](int z) { return 2.0 * (z < 9 ? z : z + 2); };
  const Scan scan = scan_of(files_of(options));
  EXPECT_EQ(only(scan).code, "missing_slices");
  EXPECT_NE(only(scan).text.find("2 slices are missing"), std::string::npos);
}

TEST(Case6, ResamplesVaryingSpacingUnlessItVariesTooMuch) {
  Options options = plain_ct();
  options.place = [](int z) { return z < 10 ? 2.0 * z : 20 + 3.3 * (z - 10); };
  const Scan scan = scan_of(files_of(options));
  const Assessment& a = only(scan);
  ASSERT_TRUE(a.suitable) << a.text;
  EXPECT_NEAR(a.spacing[2], 2, 0.1);
  EXPECT_EQ(a.repairs.size(), 1u);
  options.place = [](int z) { return z < 10 ? 2.0 * z : 20 + 17 * (z - 10); };
  EXPECT_EQ(code_of(options), "varying_spacing");
}

TEST(Case7, KeepsDuplicateSliceOnce) {
  std::vector<std::string> files = files_of(plain_ct());
  files.push_back(files[4]);
  files.insert(files.begin(), files[11]);
  const Scan scan = scan_of(files);
  const Assessment& a = only(scan);
  ASSERT_TRUE(a.suitable) << a.text;
  EXPECT_EQ(a.size[2], 20u);
  ASSERT_EQ(a.repairs.size(), 1u);
  EXPECT_NE(a.repairs[0].find("2 slices were duplicated"), std::string::npos);
}

TEST(Case7, RefusesDifferentSlicesWithTheSameUid) {
  Options options = plain_ct();
  const std::string uid = new_uid();
  options.change = [&](int z, SeriesSpec&, SliceSpec& slice) {
    if (z == 3 || z == 8) slice.sop_uid = uid;
  };
  EXPECT_EQ(code_of(options), "repeated_identifier");
}

TEST(Case9, RefusesScout) {
  Options options = plain_ct();
  options.slices = 1;
  options.series.image_type = "ORIGINAL\\PRIMARY\\LOCALIZER";
  EXPECT_EQ(code_of(options), "scout");
}

TEST(Case9, SkipsScoutsInASuitableSeries) {
  Options options = plain_ct();
  std::vector<std::string> files = files_of(options);
  Options scout = options;
  scout.slices = 2;
  scout.rows = 30;
  scout.series.image_type = "ORIGINAL\\PRIMARY\\LOCALIZER";
  for (const std::string& file : files_of(scout)) files.push_back(file);
  Options sagittal = options;  // not called a scout, but with another orientation
  sagittal.slices = 1;
  sagittal.series.orientation = {0, 1, 0, 0, 0, -1};
  for (const std::string& file : files_of(sagittal)) files.push_back(file);
  const Scan scan = scan_of(files);
  const Assessment& a = only(scan);
  ASSERT_TRUE(a.suitable) << a.text;
  EXPECT_EQ(a.size[2], 20u);
  ASSERT_EQ(a.repairs.size(), 1u);
  EXPECT_NE(a.repairs[0].find("3 overview images"), std::string::npos);
}

TEST(Case10, RefusesProjections) {
  Options options = plain_ct();
  options.change = [](int z, SeriesSpec& series, SliceSpec& slice) {
    const double angle = z * 0.3;
    series.orientation = {std::cos(angle), std::sin(angle), 0, 0, 0, -1};
    slice.position = {std::cos(angle) * 100, std::sin(angle) * 100, 50};
  };
  EXPECT_EQ(code_of(options), "views_not_slices");
  options = plain_ct();
  options.series.image_type = "ORIGINAL\\PRIMARY\\PROJECTION IMAGE\\MIP";
  EXPECT_EQ(code_of(options), "views_not_slices");
}

TEST(Case11, RefusesRepeatedPosition) {
  Options options = plain_ct();
  options.place = [](int) { return 5.0; };
  EXPECT_EQ(code_of(options), "one_position");
}

TEST(Case12, RefusesMultiFrameFilesWithoutFramePositions) {
  Options options = plain_ct();
  options.slices = 16;
  options.change = [](int, SeriesSpec&, SliceSpec& slice) {
    slice.extra.push_back({0x0028, 0x0008, "IS", "2", {}});
    const std::vector<std::uint8_t> one = slice.pixels;
    slice.pixels.insert(slice.pixels.end(), one.begin(), one.end());
  };
  EXPECT_EQ(code_of(options), "no_position");
  options.series.sop_class = "1.2.840.10008.5.1.4.1.1.2.1";
  EXPECT_EQ(code_of(options), "no_position");
}

TEST(Case13, RefusesSlicesWithoutPosition) {
  Options options = plain_ct();
  options.series.with_geometry = false;
  EXPECT_EQ(code_of(options), "no_position");
}

TEST(Case14, KeepsTheLargestGroupOfTheSameSize) {
  Options options = plain_ct();
  options.slices = 24;
  options.change = [](int z, SeriesSpec& series, SliceSpec&) {
    if (z >= 20) series.pixel_spacing = {0.9, 0.9};
  };
  const Scan scan = scan_of(files_of(options));
  const Assessment& a = only(scan);
  ASSERT_TRUE(a.suitable) << a.text;
  EXPECT_EQ(a.size[2], 20u);
  ASSERT_EQ(a.repairs.size(), 1u);
  EXPECT_NE(a.repairs[0].find("4 slices of a different size"), std::string::npos);
  options.change = [](int z, SeriesSpec& series, SliceSpec&) {
    if (z >= 12) series.pixel_spacing = {0.9, 0.9};
  };
  EXPECT_EQ(code_of(options), "mixed");
}

TEST(Case15, UnifiesRescaleSlopesOfSlices) {
  Options options = plain_ct();
  options.series.sop_class = "1.2.840.10008.5.1.4.1.1.128";
  options.series.modality = "PT";
  options.change = [](int z, SeriesSpec& series, SliceSpec&) { series.slope = 1 + 0.01 * z; };
  const Scan scan = scan_of(files_of(options));
  const Assessment& a = only(scan);
  ASSERT_TRUE(a.suitable) << a.text;
  EXPECT_NEAR(a.unit, 1.19, 1e-9);
  EXPECT_EQ(a.repairs.size(), 1u);
  options.change = [](int z, SeriesSpec& series, SliceSpec&) { series.slope = z == 4 ? 0 : 1; };
  EXPECT_EQ(code_of(options), "bad_rescale");
}

TEST(Scale, RefusesImplausibleRescaleValues) {
  for (const double slope : {1e38, -1e38, 1e300, 1e-300}) {
    Options options = plain_ct();
    options.series.slope = slope;
    EXPECT_EQ(code_of(options), "bad_rescale") << slope;
  }
  Options options = plain_ct();
  options.series.intercept = 1e30;
  EXPECT_EQ(code_of(options), "bad_rescale");
}

TEST(Case18, RefusesColourImagesAsScreenshots) {
  Options options = plain_ct();
  options.series.photometric = "RGB";
  options.series.samples = 3;
  options.series.bits_allocated = options.series.bits_stored = 8;
  options.series.high_bit = 7;
  options.change = [](int, SeriesSpec& series, SliceSpec& slice) {
    slice.pixels.assign(std::size_t{3} * series.rows * series.columns, 77);
  };
  EXPECT_EQ(code_of(options), "screenshots");
  options = plain_ct();
  options.series.photometric = "PALETTE COLOR";
  EXPECT_EQ(code_of(options), "screenshots");
}

TEST(Case19, NamesUnsupportedCompression) {
  std::vector<std::string> files = files_of(plain_ct());
  for (std::string& file : files) {
    // MPEG-2 replaces explicit little endian, with the same length.
    const std::string from = std::string("1.2.840.10008.1.2.1") + '\0';
    const std::size_t at = file.find(from);
    ASSERT_NE(at, std::string::npos);
    file.replace(at, from.size(), "1.2.840.10008.1.2.9\0");
    file[at + 19] = '\0';
  }
  const Choice choice = choose(scan_of(files));
  EXPECT_EQ(choice.code, "unsupported_compression");
  EXPECT_NE(choice.text.find("1.2.840.10008.1.2.9"), std::string::npos) << choice.text;
}

TEST(Case21, CountsTruncatedFileAsMissingSlice) {
  std::vector<std::string> files = files_of(plain_ct());
  files[5].resize(files[5].size() / 2);  // slice 18 of 20
  const Scan one = scan_of(files);
  EXPECT_EQ(one.left_out.damaged, 1u);
  const Choice filled = choose(one);
  ASSERT_TRUE(filled.suitable) << filled.text;
  EXPECT_EQ(filled.repairs.size(), 2u) << "that one was damaged, and filled in";
  files[6].resize(files[6].size() / 2);  // slice 5
  const Choice choice = choose(scan_of(files));
  EXPECT_EQ(choice.code, "missing_slices");
  EXPECT_NE(choice.text.find("damaged"), std::string::npos) << choice.text;
}

TEST(Case21, ReportsTruncatedFileAtTheEndOfTheStack) {
  Options options = plain_ct();
  std::vector<std::string> files = files_of(options);
  for (int n = 0; n < 20; ++n) {
    if ((7 * n + 3) % 20 == 19) files[static_cast<std::size_t>(n)].resize(300);
  }
  const Choice choice = choose(scan_of(files));
  ASSERT_TRUE(choice.suitable) << choice.text;
  ASSERT_EQ(choice.repairs.size(), 1u);
  EXPECT_NE(choice.repairs[0].find("1 file was damaged"), std::string::npos);
}

TEST(Case22, SkipsObjectsThatAreNotSlices) {
  const char* const others[] = {"1.2.840.10008.5.1.4.1.1.7",      // secondary capture
                                "1.2.840.10008.5.1.4.1.1.88.67",  // dose report
                                "1.2.840.10008.5.1.4.1.1.104.1",  // PDF
                                "1.2.840.10008.5.1.4.1.1.481.3",  // structure set
                                "1.2.840.10008.5.1.4.1.1.66.4"};  // segmentation
  for (const char* sop_class : others) {
    Options options = plain_ct();
    options.series.sop_class = sop_class;
    const Scan scan = scan_of(files_of(options));
    EXPECT_TRUE(scan.series.empty()) << sop_class;
    EXPECT_EQ(scan.left_out.not_slices, 20u);
    EXPECT_EQ(choose(scan).code, "no_slices");
  }
}

TEST(Case23, SeparatesPatientsWithinASeries) {
  Options options = plain_ct();
  std::vector<std::string> files = files_of(options);
  options.series.extra = {{0x0010, 0x0020, "LO", "another", {}}};
  for (const std::string& file : files_of(options)) files.push_back(file);
  const Scan scan = scan_of(files);
  EXPECT_EQ(scan.series.size(), 2u);
  EXPECT_EQ(choose(scan).code, "several_series");
  EXPECT_TRUE(choose_largest(scan).suitable);
}

TEST(Case24, RefusesTooFewSlices) {
  Options options = plain_ct();
  for (const int n : {1, 3, 15}) {
    options.slices = n;
    EXPECT_EQ(code_of(options), "too_few_slices") << n;
  }
  options.slices = 16;
  EXPECT_TRUE(only(scan_of(files_of(options))).suitable);
  options.slices = 20;
  options.spacing = 0.9;
  EXPECT_EQ(code_of(options), "too_few_slices") << "18 mm";
}

TEST(Case25, RefusesSeriesOverTheQuota) {
  ScanLimits limits;
  limits.most_voxels = 12 * 10 * 20 - 1;
  EXPECT_EQ(choose(scan_of(files_of(plain_ct()), limits)).code, "over_quota");
  limits.most_voxels = 12 * 10 * 20;
  EXPECT_TRUE(choose(scan_of(files_of(plain_ct()), limits)).suitable);
}

TEST(Originals, RefusesDerivedImages) {
  Options options = plain_ct();
  options.series.image_type = "DERIVED\\SECONDARY\\REFORMATTED";
  EXPECT_EQ(code_of(options), "not_original");
}

TEST(Scale, RefusesUnsignedCtWithoutRescale) {
  Options options = plain_ct();
  options.series.with_rescale = false;
  EXPECT_EQ(code_of(options), "no_rescale");
}

TEST(EmptyInput, ReportsEmptyAndForeignInput) {
  EXPECT_EQ(choose(scan_of({})).code, "empty");
  EXPECT_EQ(choose(scan_of({"", "plain text, no picture", std::string(9000, 'x')})).code,
            "not_dicom");
}

TEST(Folder, ReadsSubfoldersButNoLinks) {
  namespace fs = std::filesystem;
  std::string folder = (fs::temp_directory_path() / "diaphane-scan-XXXXXX").string();
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  fs::create_directories(folder + "/a/b");
  int n = 0;
  for (const std::string& file : files_of(plain_ct())) {
    std::ofstream(folder + (++n % 2 == 0 ? "/a/" : "/a/b/") + std::to_string(n), std::ios::binary)
        << file;
  }
  fs::create_symlink(folder + "/a", folder + "/loop");
  fs::create_symlink("/etc/hostname", folder + "/link");
  auto source = FolderSource::open(folder, ScanLimits().file.file_bytes);
  ASSERT_TRUE(source.has_value());
  EXPECT_EQ(source->size(), 20u);
  auto found = scan(*source, {});
  ASSERT_TRUE(found.has_value());
  EXPECT_TRUE(choose(*found).suitable);
  EXPECT_EQ(FolderSource::open(folder + "/none", 1000).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(FolderSource::open(folder + "/a/2", 1000).error().code, ErrorCode::kNotFound);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace diaphane::dicom
