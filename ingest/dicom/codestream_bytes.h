#pragma once

// For the readers of compressed pictures: big-endian numbers.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "ingest/dicom/codestream.h"

namespace diaphane::dicom {

using Fault = std::optional<std::string_view>;
inline constexpr std::string_view kBroken = "the compressed picture is broken";
inline constexpr std::string_view kOtherSize =
    "the compressed picture has another size than it should";
inline constexpr std::string_view kOtherKind =
    "the compressed picture is of another kind than it should";
inline constexpr std::string_view kOverdone = "the compressed picture is cut into too many pieces";

/// Numbers beyond the end are the caller's fault: ask has() first.
class BigEndian {
 public:
  explicit BigEndian(std::span<const std::byte> data) : data_(data) {}
  std::size_t size() const { return data_.size(); }
  bool has(std::size_t at, std::size_t bytes) const {
    return at <= data_.size() && bytes <= data_.size() - at;
  }
  std::uint32_t u8(std::size_t at) const { return std::to_integer<std::uint32_t>(data_[at]); }
  std::uint32_t u16(std::size_t at) const { return u8(at) << 8 | u8(at + 1); }
  std::uint32_t u32(std::size_t at) const { return u16(at) << 16 | u16(at + 2); }

 private:
  std::span<const std::byte> data_;
};

Fault fault_of_jpeg2000(const BigEndian& in, const PictureClaim& claim);

}  // namespace diaphane::dicom
