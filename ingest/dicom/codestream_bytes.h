#pragma once

// Big-endian numbers for the parsers of compressed images.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "ingest/dicom/codestream.h"

namespace diaphane::dicom {

using Fault = std::optional<std::string_view>;
inline constexpr std::string_view kBroken = "the compressed image is corrupted";
inline constexpr std::string_view kOtherSize = "the compressed image has an unexpected size";
inline constexpr std::string_view kOtherKind = "the compressed image has an unexpected type";
inline constexpr std::string_view kOverdone = "the compressed image consists of too many pieces";

/// Precondition of reads: has() returned true for the same range.
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
