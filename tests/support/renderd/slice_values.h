#pragma once

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdint>
#include <string>
#include <vector>

#include "api/proto/stream.pb.h"

namespace diaphane::render {

/// Decodes ExactSlice.data or ExactSlice.second as the protocol specifies.
inline std::vector<std::int16_t> values_of(const diaphane::v1::ExactSlice& slice,
                                           const std::string& data) {
  const std::size_t pixels = std::size_t{slice.columns()} * slice.rows();
  std::vector<unsigned char> bytes(2 * pixels);
  auto length = static_cast<uLongf>(bytes.size());
  EXPECT_EQ(uncompress(bytes.data(), &length, reinterpret_cast<const Bytef*>(data.data()),
                       static_cast<uLong>(data.size())),
            Z_OK);
  std::vector<std::int16_t> values(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    values[i] = static_cast<std::int16_t>(bytes[i] + 256 * bytes[pixels + i]);
  }
  return values;
}
inline std::vector<std::int16_t> values_of(const diaphane::v1::ExactSlice& slice) {
  return values_of(slice, slice.data());
}

/// Decodes ExactSlice.labels, which has one byte per pixel.
inline std::vector<std::uint8_t> labels_of(const diaphane::v1::ExactSlice& slice) {
  std::vector<std::uint8_t> labels(std::size_t{slice.columns()} * slice.rows());
  auto length = static_cast<uLongf>(labels.size());
  EXPECT_EQ(
      uncompress(labels.data(), &length, reinterpret_cast<const Bytef*>(slice.labels().data()),
                 static_cast<uLong>(slice.labels().size())),
      Z_OK);
  EXPECT_EQ(length, labels.size());
  return labels;
}

}  // namespace diaphane::render
