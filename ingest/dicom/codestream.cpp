#include "ingest/dicom/codestream.h"

#include <algorithm>
#include <array>

#include "ingest/dicom/codestream_bytes.h"

namespace diaphane::dicom {
namespace {

/// Returns the offset of the first marker after a scan's header at `at` that is not part of the
/// scan's data. 0xFF00 and restart markers are part of it (T.81, B.1.1.5), and so is everything
/// below 0xFF80 in JPEG-LS (T.87, A.1).
std::size_t past_scan(const BigEndian& in, std::size_t at, bool is_ls) {
  for (; at + 1 < in.size(); ++at) {
    if (in.u8(at) != 0xFF) continue;
    const std::uint32_t next = in.u8(at + 1);
    const bool data = is_ls ? next < 0x80 : next == 0x00 || (next >= 0xD0 && next <= 0xD7);
    if (!data && next != 0xFF) return at;
  }
  return in.size();
}

struct JpegFrame {
  std::uint32_t marker = 0, bits = 0, height = 0, width = 0, components = 0;
};

/// Checks that the JPEG process matches the transfer syntax. GDCM 3.0.21 aborts with a failed
/// assertion on lossless images of fewer than eight bits, which scanners do not produce.
Fault fault_of_frame(const JpegFrame& frame, const TransferSyntax& syntax,
                     const PictureClaim& claim) {
  const std::string_view uid = syntax.uid;
  bool fits = false;
  if (syntax.packing == Packing::kJpegLs) {
    fits = frame.marker == 0xFFF7 && frame.bits >= 2 && frame.bits <= 16;
  } else if (uid.ends_with(".50")) {
    fits = frame.marker == 0xFFC0 && frame.bits == 8;
  } else if (uid.ends_with(".51")) {
    // T.81 does not allow 16 bits, but GDCM writes and reads them.
    fits = (frame.marker == 0xFFC0 || frame.marker == 0xFFC1) &&
           (frame.bits == 8 || frame.bits == 12 || frame.bits == 16);
  } else {
    fits = frame.marker == 0xFFC3 && frame.bits >= 8 && frame.bits <= 16;
  }
  if (!fits || frame.bits > claim.bits) return kOtherKind;
  if (frame.width != claim.width || frame.height != claim.height ||
      frame.components != claim.components) {
    return kOtherSize;
  }
  return std::nullopt;
}

bool is_frame(std::uint32_t marker) {
  return marker == 0xFFF7 || (marker >= 0xFFC0 && marker <= 0xFFCF && marker != 0xFFC4 &&
                              marker != 0xFFC8 && marker != 0xFFCC);
}

Fault fault_of_jpeg(const BigEndian& in, const TransferSyntax& syntax, const PictureClaim& claim) {
  const bool is_ls = syntax.packing == Packing::kJpegLs;
  if (!in.has(0, 4) || in.u16(0) != 0xFFD8) return kBroken;
  std::uint32_t frames = 0, scans = 0, segments = 0;
  constexpr std::uint32_t kMostSegments = 1000;
  for (std::size_t at = 2; at + 2 <= in.size();) {
    const std::uint32_t marker = in.u16(at);
    if (marker == 0xFFFF) {  // fill bytes
      ++at;
      continue;
    }
    if (marker == 0xFFD9) break;  // end of image, where decoders stop
    if (marker < 0xFFC0 || !in.has(at, 4) || in.u16(at + 2) < 2) return kBroken;
    const std::size_t length = in.u16(at + 2);
    if (!in.has(at, 2 + length)) return kBroken;
    if (++segments > kMostSegments) return kOverdone;
    if (marker == 0xFFDA) {
      if (frames == 0) return kBroken;
      if (++scans > claim.components) return kOverdone;
      at = past_scan(in, at + 2 + length, is_ls);
      continue;
    }
    if (is_frame(marker)) {
      if (++frames > 1 || length < 8) return kBroken;
      const JpegFrame frame{marker, in.u8(at + 4), in.u16(at + 5), in.u16(at + 7), in.u8(at + 9)};
      if (auto fault = fault_of_frame(frame, syntax, claim)) return fault;
    }
    // Rejects what is not supported: a height that follows later, arithmetic coding, and presets
    // with another size or palettes.
    const bool preset = is_ls && marker == 0xFFF8 && (length < 3 || in.u8(at + 4) != 1);
    if (marker == 0xFFDC || marker == 0xFFCC || preset) return kOtherKind;
    at += 2 + length;
  }
  return frames == 1 && scans > 0 ? std::nullopt : Fault(kBroken);
}

/// Returns the unpacked size of a segment in bytes (PackBits), or `most` + 1 as soon as it is
/// larger.
std::uint64_t unpacked(const BigEndian& in, std::size_t at, std::size_t end, std::uint64_t most) {
  std::uint64_t bytes = 0;
  while (at < end && bytes <= most) {
    const std::uint32_t control = in.u8(at);
    if (control == 0x80) {
      ++at;
    } else if (control < 0x80) {
      const std::size_t run = control + 1;
      if (run > end - at - 1) break;  // truncated
      bytes += run;
      at += 1 + run;
    } else {
      if (end - at < 2) break;
      bytes += 257 - control;
      at += 2;
    }
  }
  return std::min(bytes, most + 1);
}

Fault fault_of_rle(std::span<const std::byte> picture, const PictureClaim& claim) {
  constexpr std::size_t kHeader = 64;
  const BigEndian in(picture);
  if (picture.size() < kHeader) return kBroken;
  const auto word = [&](std::size_t n) {  // the header is little endian
    const std::size_t at = 4 * n;
    return in.u8(at) | in.u8(at + 1) << 8 | in.u8(at + 2) << 16 | in.u8(at + 3) << 24;
  };
  const std::uint32_t segments = word(0);
  if (segments != claim.components * ((claim.bits + 7) / 8) || segments > 15) return kBroken;
  const std::uint64_t expected = std::uint64_t{claim.width} * claim.height;
  for (std::uint32_t n = 1; n <= segments; ++n) {
    const std::size_t begin = word(n), end = n < segments ? word(n + 1) : picture.size();
    if (begin < kHeader || begin >= end || end > picture.size()) return kBroken;
    // Some writers let the last run exceed the image.
    const std::uint64_t bytes = unpacked(in, begin, end, expected + 128);
    if (bytes < expected || bytes > expected + 128) return kOtherSize;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string_view> fault_of(std::span<const std::byte> picture,
                                         const TransferSyntax& syntax, const PictureClaim& claim) {
  switch (syntax.packing) {
    case Packing::kJpeg:
    case Packing::kJpegLs:
      return fault_of_jpeg(BigEndian(picture), syntax, claim);
    case Packing::kJpeg2000:
      return fault_of_jpeg2000(BigEndian(picture), claim);
    case Packing::kRle:
      return fault_of_rle(picture, claim);
    case Packing::kNative:
      break;
  }
  return kOtherKind;
}

}  // namespace diaphane::dicom
