#include "ingest/dicom/codestream.h"

#include <algorithm>

namespace diaphane::dicom {
namespace {

class Bytes {
 public:
  explicit Bytes(std::span<const std::byte> data) : data_(data) {}
  std::size_t size() const { return data_.size(); }
  std::uint32_t u8(std::size_t at) const { return std::to_integer<std::uint32_t>(data_[at]); }
  std::uint32_t u16(std::size_t at) const { return u8(at) << 8 | u8(at + 1); }
  std::uint32_t u32(std::size_t at) const { return u16(at) << 16 | u16(at + 2); }

 private:
  std::span<const std::byte> data_;
};

bool is_frame_header(std::uint32_t marker) {
  if (marker == 0xFFF7) return true;  // JPEG-LS
  return marker >= 0xFFC0 && marker <= 0xFFCF && marker != 0xFFC4 && marker != 0xFFC8 &&
         marker != 0xFFCC;
}

std::optional<PictureSize> of_jpeg(const Bytes& in) {
  if (in.size() < 4 || in.u16(0) != 0xFFD8) return std::nullopt;
  std::size_t at = 2;
  while (at + 4 <= in.size()) {
    if (in.u8(at) != 0xFF) return std::nullopt;
    if (in.u8(at + 1) == 0xFF) {  // fill
      ++at;
      continue;
    }
    const std::uint32_t marker = in.u16(at);
    if (is_frame_header(marker)) {
      if (at + 10 > in.size()) return std::nullopt;
      return PictureSize{in.u16(at + 7), in.u16(at + 5), in.u8(at + 9)};
    }
    at += 2 + in.u16(at + 2);
  }
  return std::nullopt;
}

std::optional<PictureSize> of_jpeg2000(const Bytes& in) {
  // In the box format the codestream stands somewhere behind the boxes: look for SOC and SIZ.
  for (std::size_t at = 0; at + 42 <= in.size() && at < 4096; ++at) {
    if (in.u32(at) != 0xFF4FFF51) continue;
    const std::uint32_t x1 = in.u32(at + 8), y1 = in.u32(at + 12);
    const std::uint32_t x0 = in.u32(at + 16), y0 = in.u32(at + 20);
    if (x0 >= x1 || y0 >= y1) return std::nullopt;
    return PictureSize{x1 - x0, y1 - y0, in.u16(at + 40)};
  }
  return std::nullopt;
}

}  // namespace

std::optional<PictureSize> picture_size(std::span<const std::byte> fragment, Packing packing) {
  const Bytes in(fragment);
  switch (packing) {
    case Packing::kJpeg:
    case Packing::kJpegLs:
      return of_jpeg(in);
    case Packing::kJpeg2000:
      return of_jpeg2000(in);
    case Packing::kNative:
    case Packing::kRle:
      break;
  }
  return std::nullopt;
}

}  // namespace diaphane::dicom
