#include "renderd/encode/slice_codec.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <random>
#include <vector>

namespace diaphane::render {
namespace {

// Decodes as the protocol specifies, without the project's code.
std::vector<std::int16_t> decoded(const std::string& coded, std::size_t pixels) {
  std::vector<unsigned char> bytes(2 * pixels);
  auto length = static_cast<uLongf>(bytes.size());
  EXPECT_EQ(uncompress(bytes.data(), &length, reinterpret_cast<const Bytef*>(coded.data()),
                       static_cast<uLong>(coded.size())),
            Z_OK);
  EXPECT_EQ(length, bytes.size());
  std::vector<std::int16_t> values(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    values[i] = static_cast<std::int16_t>(bytes[i] + 256 * bytes[pixels + i]);
  }
  return values;
}

TEST(SliceCodec, RoundTripsEveryValueExactly) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> any(-32768, 32767);
  std::vector<std::int16_t> values{-32768, 32767, -1, 0, 255, 256};
  for (int i = 0; i < 5000; ++i) values.push_back(static_cast<std::int16_t>(any(random)));
  const auto coded = code_slice(values);
  ASSERT_TRUE(coded);
  EXPECT_EQ(decoded(*coded, values.size()), values);
}

TEST(SliceCodec, CompressesUniformSliceWell) {
  const std::vector<std::int16_t> values(512 * 512, -1000);
  const auto coded = code_slice(values);
  ASSERT_TRUE(coded);
  EXPECT_LT(coded->size(), 5000U);
  EXPECT_EQ(decoded(*coded, values.size()), values);
}

TEST(SliceCodec, RoundTripsLabelsAndLeavesOutSlicesWithoutLabels) {
  std::vector<std::uint8_t> labels(1000);
  EXPECT_EQ(code_labels(labels).value(), "");
  for (std::size_t i = 0; i < labels.size(); ++i) labels[i] = static_cast<std::uint8_t>(i);
  const std::string coded = code_labels(labels).value();
  std::vector<std::uint8_t> bytes(labels.size());
  auto length = static_cast<uLongf>(bytes.size());
  ASSERT_EQ(uncompress(bytes.data(), &length, reinterpret_cast<const Bytef*>(coded.data()),
                       static_cast<uLong>(coded.size())),
            Z_OK);
  EXPECT_EQ(length, labels.size());
  EXPECT_EQ(bytes, labels);
}

}  // namespace
}  // namespace diaphane::render
