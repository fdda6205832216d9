#include <algorithm>

#include "ingest/dicom/codestream_bytes.h"

namespace diaphane::dicom {
namespace {

// ITU-T T.800, A.2 to A.6. A decoder allocates some hundred bytes for each of these before it reads
// an image. Honest images have a few thousand at most (tiles of 128 x 128, blocks of 32 x 32).
constexpr std::uint64_t kMostTiles = 1024;
constexpr std::uint64_t kMostPieces = std::uint64_t{1}
                                      << 18;  ///< limit for precincts and for code-blocks
constexpr std::uint32_t kMostLayers = 256;
constexpr std::uint32_t kMostTileParts = 4096;

std::uint64_t ceil_div(std::uint64_t a, std::uint64_t b) { return (a + b - 1) / b; }

struct Picture {
  std::uint64_t width = 0, height = 0;
  std::uint64_t tiles = 0;
};

/// Reads the SIZ segment at `at`, after its marker.
Fault read_size(const BigEndian& in, std::size_t at, const PictureClaim& claim, Picture& picture) {
  if (!in.has(at, 40)) return kBroken;
  const std::uint64_t x1 = in.u32(at + 6), y1 = in.u32(at + 10);
  const std::uint64_t x0 = in.u32(at + 14), y0 = in.u32(at + 18);
  const std::uint64_t tile_w = in.u32(at + 22), tile_h = in.u32(at + 26);
  const std::uint64_t tile_x = in.u32(at + 30), tile_y = in.u32(at + 34);
  const std::uint32_t components = in.u16(at + 38);
  if (x0 >= x1 || y0 >= y1 || x1 - x0 != claim.width || y1 - y0 != claim.height ||
      components != claim.components) {
    return kOtherSize;
  }
  if (in.u16(at + 2) != 38 + 3 * components || !in.has(at + 2, in.u16(at + 2))) return kBroken;
  for (std::uint32_t c = 0; c < components; ++c) {
    const std::size_t part = at + 40 + std::size_t{3} * c;
    const std::uint32_t bits = (in.u8(part) & 0x7F) + 1;
    if (bits > claim.bits || in.u8(part + 1) != 1 || in.u8(part + 2) != 1) return kOtherKind;
  }
  if (tile_w == 0 || tile_h == 0 || tile_x > x0 || tile_y > y0 || tile_x + tile_w <= x0 ||
      tile_y + tile_h <= y0) {
    return kBroken;
  }
  picture.width = x1 - x0;
  picture.height = y1 - y0;
  picture.tiles = ceil_div(x1 - tile_x, tile_w) * ceil_div(y1 - tile_y, tile_h);
  return picture.tiles > kMostTiles ? Fault(kOverdone) : std::nullopt;
}

/// Checks the COD segment at `at`. `length` includes the length field.
Fault check_style(const BigEndian& in, std::size_t at, std::size_t length, const Picture& picture) {
  if (length < 12) return kBroken;
  const bool own_precincts = (in.u8(at + 4) & 1) != 0;
  const std::uint32_t layers = in.u16(at + 6), levels = in.u8(at + 9);
  const std::uint32_t block_x = in.u8(at + 10) + 2, block_y = in.u8(at + 11) + 2;
  if (layers == 0 || levels > 32 || block_x > 10 || block_y > 10 || block_x + block_y > 12) {
    return kBroken;
  }
  if (own_precincts && length < std::size_t{12} + levels + 1) return kBroken;
  if (layers > kMostLayers) return kOverdone;
  std::uint64_t blocks = 0, precincts = 0;
  for (std::uint32_t r = 0; r <= levels; ++r) {
    const std::uint32_t shrink = levels - r;
    const std::uint64_t w = ceil_div(picture.width, std::uint64_t{1} << shrink);
    const std::uint64_t h = ceil_div(picture.height, std::uint64_t{1} << shrink);
    const std::uint32_t size = own_precincts ? in.u8(at + 14 + r) : 0xFF;
    const std::uint32_t px = size & 15, py = size >> 4;
    if (r > 0 && (px == 0 || py == 0)) return kBroken;
    precincts += ceil_div(w, std::uint64_t{1} << px) * ceil_div(h, std::uint64_t{1} << py);
    // A block is at most as large as its precinct, which is twice as large as its bands one level
    // up.
    const std::uint32_t bx = std::min(block_x, r > 0 ? px - 1 : px);
    const std::uint32_t by = std::min(block_y, r > 0 ? py - 1 : py);
    blocks += ceil_div(w, std::uint64_t{1} << bx) * ceil_div(h, std::uint64_t{1} << by);
  }
  // Each tile rounds up separately and is decoded layer by layer.
  const std::uint64_t rounding = picture.tiles * (levels + 1);
  if (precincts + rounding > kMostPieces || blocks + rounding > kMostPieces) return kOverdone;
  return (precincts + rounding) * layers > kMostPieces * 4 ? Fault(kOverdone) : std::nullopt;
}

class Reader {
 public:
  Reader(const BigEndian& in, const PictureClaim& claim, std::size_t begin)
      : in_(in), claim_(claim), at_(begin) {}

  Fault run() {
    if (auto fault = read_size(in_, at_ + 2, claim_, picture_)) return fault;
    at_ += 4 + std::size_t{in_.u16(at_ + 4)};
    if (auto fault = header(0xFF90)) return fault;
    if (styles_ == 0) return kBroken;
    for (std::uint32_t parts = 0; in_.has(at_, 12) && in_.u16(at_) == 0xFF90; ++parts) {
      if (parts > kMostTileParts) return kOverdone;
      const std::size_t begin = at_;
      const std::uint32_t length = in_.u32(at_ + 6);  // 0: to the end of the codestream
      if (in_.u16(at_ + 2) != 10 || (length != 0 && length < 14)) return kBroken;
      at_ += 12;
      if (auto fault = header(0xFF93)) return fault;
      if (length == 0) return std::nullopt;
      if (!in_.has(begin, length)) return kBroken;
      at_ = begin + length;
    }
    return std::nullopt;
  }

 private:
  /// Reads segments up to the marker `stop`, and leaves `at_` at that marker.
  Fault header(std::uint32_t stop) {
    while (in_.has(at_, 4)) {
      const std::uint32_t marker = in_.u16(at_);
      if (marker == stop) return std::nullopt;
      const std::size_t length = in_.u16(at_ + 2);
      if (marker < 0xFF30 || length < 2 || !in_.has(at_ + 2, length)) return kBroken;
      if (marker == 0xFF51) return kBroken;  // a second size
      // A separate style for the only component and further progression lists do not occur in
      // scans, so a second parser is not worth its cost.
      if (marker == 0xFF53 || marker == 0xFF5F) return kOtherKind;
      if (marker == 0xFF52) {
        ++styles_;
        if (auto fault = check_style(in_, at_, length, picture_)) return fault;
      }
      at_ += 2 + length;
    }
    // T.800 allows the last tile-part to have no data.
    return in_.has(at_, 2) && in_.u16(at_) == stop ? std::nullopt : Fault(kBroken);
  }

  BigEndian in_;
  PictureClaim claim_;
  std::size_t at_;
  Picture picture_;
  std::uint32_t styles_ = 0;
};

}  // namespace

Fault fault_of_jpeg2000(const BigEndian& in, const PictureClaim& claim) {
  constexpr std::uint32_t kBegin = 0xFF4FFF51;  // SOC, SIZ
  if (in.has(0, 42) && in.u32(0) == kBegin) return Reader(in, claim, 0).run();
  // In the box format (T.800, I.4), the codestream is in the first box of its type.
  constexpr std::uint32_t kSignature = 0x6A502020, kCodestream = 0x6A703263;
  if (!in.has(0, 12) || in.u32(4) != kSignature) return kBroken;
  for (std::size_t at = 0; in.has(at, 8);) {
    const std::uint64_t length = in.u32(at);
    if (in.u32(at + 4) == kCodestream) {
      const std::size_t begin = at + (length == 1 ? 16 : 8);
      if (!in.has(begin, 42) || in.u32(begin) != kBegin) return kBroken;
      return Reader(in, claim, begin).run();
    }
    if (length < 8 || !in.has(at, length)) return kBroken;
    at += length;
  }
  return kBroken;
}

}  // namespace diaphane::dicom
