#include "ingest/dicom/values.h"

#include <gtest/gtest.h>

#include "ingest/dicom/read_slice.h"
#include "tests/support/ingest/test_series.h"

namespace diaphane::dicom {
namespace {

using namespace testing;

/// Returns the values of the first file of a series, written and read back through GDCM.
std::vector<std::int32_t> read_back(const Options& options, int& z) {
  const std::vector<std::string> files = files_of(options);
  z = 3 % options.slices;
  const auto bytes = std::as_bytes(std::span(files[0]));
  const Precheck checked = precheck(bytes, {});
  EXPECT_EQ(checked.state, FileState::kFit) << checked.text;
  auto slices = read_slices(checked);
  EXPECT_TRUE(slices.has_value()) << slices.error().message;
  if (!slices) return {};
  auto values = read_values(checked, slices->front());
  EXPECT_TRUE(values.has_value()) << values.error().message;
  return values.value_or(Values()).values;
}

void expect_the_picture(const Options& options, const std::string& what) {
  int z = 0;
  const auto values = read_back(options, z);
  ASSERT_EQ(values.size(), static_cast<std::size_t>(options.rows * options.columns)) << what;
  for (int y = 0; y < options.rows; ++y) {
    for (int x = 0; x < options.columns; ++x) {
      ASSERT_EQ(values[static_cast<std::size_t>(y * options.columns + x)], value_at(x, y, z))
          << what << " at " << x << ", " << y;
    }
  }
}

TEST(Values, EveryPixelLayoutGivesTheSameHounsfieldUnits) {
  for (const int is_signed : {0, 1}) {
    for (const int stored : {12, 13, 16}) {
      for (int high = stored - 1; high < 16; ++high) {
        Options options = plain_ct();
        options.series.is_signed = static_cast<std::uint16_t>(is_signed);
        options.series.bits_stored = static_cast<std::uint16_t>(stored);
        options.series.high_bit = static_cast<std::uint16_t>(high);
        options.series.intercept = is_signed ? 0 : -1024;
        Slice slice;
        slice.rows = 10;
        slice.columns = 12;
        slice.modality = volume::Modality::kCt;
        slice.rescale = {1, options.series.intercept, true};
        slice.photometric = "MONOCHROME2";
        const PixelLayout layout{16, options.series.bits_stored, options.series.high_bit,
                                 is_signed == 1};
        ASSERT_TRUE(is_readable(layout));
        const auto raw = pixels_of(options, options.series, 4);
        const auto values = to_values(std::as_bytes(std::span(raw)), layout, slice).values;
        for (int i = 0; i < 120; ++i) {
          ASSERT_EQ(values[static_cast<std::size_t>(i)], value_at(i % 12, i / 12, 4))
              << is_signed << " " << stored << " " << high;
        }
      }
    }
  }
}

TEST(Values, ClearsBitsThatAreNotStored) {
  Slice slice;
  slice.rows = slice.columns = 1;
  slice.modality = volume::Modality::kMr;
  slice.photometric = "MONOCHROME2";
  const std::uint8_t raw[] = {0x34, 0xF2};  // an overlay in the four highest bits
  EXPECT_EQ(to_values(std::as_bytes(std::span(raw)), {16, 12, 11, false}, slice).values[0], 0x234);
  const std::uint8_t negative[] = {0xFF, 0x0F};
  EXPECT_EQ(to_values(std::as_bytes(std::span(negative)), {16, 12, 11, true}, slice).values[0], -1);
}

TEST(Values, CtPaddingBecomesAir) {
  Slice slice;
  slice.rows = 1;
  slice.columns = 3;
  slice.modality = volume::Modality::kCt;
  slice.photometric = "MONOCHROME2";
  slice.rescale = {1, -1024, true};
  slice.padding = std::array<double, 2>{-2000, -2000};
  const std::int16_t raw[] = {-2000, 0, 1500};
  const auto values = to_values(std::as_bytes(std::span(raw)), {16, 16, 15, true}, slice).values;
  EXPECT_EQ(values, (std::vector<std::int32_t>{kAirHu, -1024, 476}));
}

TEST(Values, MrValuesStayUnscaled) {
  Slice slice;
  slice.rows = 1;
  slice.columns = 2;
  slice.modality = volume::Modality::kMr;
  slice.photometric = "MONOCHROME2";
  slice.rescale = {2, 100, true};
  const std::uint16_t raw[] = {7, 65535};
  const auto values = to_values(std::as_bytes(std::span(raw)), {16, 16, 15, false}, slice).values;
  EXPECT_EQ(values, (std::vector<std::int32_t>{7, 65535}));
}

TEST(Values, RefusesUnsupportedPixelLayouts) {
  EXPECT_TRUE(is_readable({8, 8, 7, false}));
  EXPECT_TRUE(is_readable({16, 12, 15, true}));
  for (const PixelLayout bad :
       {PixelLayout{32, 32, 31, false}, PixelLayout{16, 17, 15, false},
        PixelLayout{16, 12, 10, false}, PixelLayout{12, 12, 11, false}, PixelLayout{1, 1, 0, false},
        PixelLayout{16, 0, 0, false}, PixelLayout{16, 12, 16, false}}) {
    EXPECT_FALSE(is_readable(bad));
  }
}

TEST(Values, KeepsTheHounsfieldUnitsOfMonochrome1) {
  for (const int is_signed : {0, 1}) {
    Options options = plain_ct();
    options.series.photometric = "MONOCHROME1";
    options.series.is_signed = static_cast<std::uint16_t>(is_signed);
    options.series.intercept = is_signed ? 0 : -1024;
    expect_the_picture(options, "MONOCHROME1");
  }
}

TEST(Values, InvertsMonochrome1WithoutUnits) {
  Slice slice;
  slice.rows = 1;
  slice.columns = 2;
  slice.modality = volume::Modality::kMr;
  slice.photometric = "MONOCHROME1";
  const std::uint16_t raw[] = {0, 0x0FFF};
  const auto bytes = std::as_bytes(std::span(raw));
  EXPECT_EQ(to_values(bytes, {16, 12, 11, false}, slice).values,
            (std::vector<std::int32_t>{4095, 0}));
  EXPECT_EQ(to_values(bytes, {16, 12, 11, true}, slice).values, (std::vector<std::int32_t>{-1, 0}));
  slice.rescale = {1, 0, true};
  EXPECT_EQ(to_values(bytes, {16, 12, 11, false}, slice, 1).values,
            (std::vector<std::int32_t>{0, 4095}))
      << "with a scale for each slice, values have units";
}

TEST(Values, EveryTransferSyntaxGivesTheSameImage) {
  const char* const lossless[] = {
      "1.2.840.10008.1.2",       // implicit little endian
      "1.2.840.10008.1.2.1",     // explicit little endian
      "1.2.840.10008.1.2.1.99",  // deflated
      "1.2.840.10008.1.2.2",     // explicit big endian
      "1.2.840.10008.1.2.5",     // RLE
      "1.2.840.10008.1.2.4.57",  // JPEG lossless
      "1.2.840.10008.1.2.4.70",  // JPEG lossless, first order
      "1.2.840.10008.1.2.4.80",  // JPEG-LS
      "1.2.840.10008.1.2.4.90",  // JPEG 2000
  };
  for (const char* uid : lossless) {
    Options options = plain_ct();
    options.rows = options.columns = 32;  // value_at stays within 12 bits
    options.series.transfer_syntax = uid;
    expect_the_picture(options, uid);
  }
}

TEST(Values, ReadsFileWithoutFileMetaHeader) {
  for (const char* uid : {"1.2.840.10008.1.2", "1.2.840.10008.1.2.1"}) {
    Options options = plain_ct();
    options.series.transfer_syntax = uid;
    std::string file = files_of(options)[0];
    const std::string first("\x08\x00\x08\x00", 4);
    for (const std::size_t from : {file.find(first), std::size_t{132}}) {
      const std::string bare = file.substr(from);
      const auto bytes = std::as_bytes(std::span(bare));
      const Precheck checked = precheck(bytes, {});
      ASSERT_EQ(checked.state, FileState::kFit) << checked.text;
      auto slices = read_slices(checked);
      ASSERT_TRUE(slices.has_value());
      auto values = read_values(checked, slices->front());
      ASSERT_TRUE(values.has_value()) << values.error().message;
      EXPECT_EQ(values->values[13], value_at(1, 1, 3)) << uid << " from " << from;
    }
  }
}

}  // namespace
}  // namespace diaphane::dicom
