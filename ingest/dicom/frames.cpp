// Extracts one frame from a file with several.
#include <algorithm>
#include <cstring>
#include <string_view>

#include "ingest/dicom/precheck.h"

namespace diaphane::dicom {
namespace {

constexpr std::uint32_t kSopClass = 0x00080016;
constexpr std::uint32_t kFrames = 0x00280008;
constexpr std::uint32_t kBitsAllocated = 0x00280100;
constexpr std::uint32_t kSamples = 0x00280002;
/// A SOP class without functional groups. The decoder does not depend on the class.
constexpr std::string_view kPlainClass{"1.2.840.10008.5.1.4.1.1.4\0", 26};

void put16(std::vector<std::byte>& out, std::uint32_t value, bool big_endian) {
  const auto low = static_cast<std::byte>(value & 0xff);
  const auto high = static_cast<std::byte>(value >> 8 & 0xff);
  out.push_back(big_endian ? high : low);
  out.push_back(big_endian ? low : high);
}

void put32(std::vector<std::byte>& out, std::uint32_t value, bool big_endian) {
  put16(out, big_endian ? value >> 16 : value & 0xffff, big_endian);
  put16(out, big_endian ? value & 0xffff : value >> 16, big_endian);
}

void put_tag(std::vector<std::byte>& out, std::uint32_t tag, bool big_endian) {
  put16(out, tag >> 16, big_endian);
  put16(out, tag & 0xffff, big_endian);
}

/// Writes the header of a top-level element.
void put_header(std::vector<std::byte>& out, const TransferSyntax& syntax, std::uint32_t tag,
                const char* vr, std::uint32_t length) {
  put_tag(out, tag, syntax.big_endian);
  if (!syntax.explicit_vr) return put32(out, length, syntax.big_endian);
  out.push_back(static_cast<std::byte>(vr[0]));
  out.push_back(static_cast<std::byte>(vr[1]));
  if (vr[0] != 'O') return put16(out, length, syntax.big_endian);
  put16(out, 0, syntax.big_endian);
  put32(out, length, syntax.big_endian);
}

std::uint32_t u16(const Precheck& in, std::size_t at) {
  const auto a = std::to_integer<std::uint32_t>(in.plain[at]);
  const auto b = std::to_integer<std::uint32_t>(in.plain[at + 1]);
  return in.syntax.big_endian ? a << 8 | b : b << 8 | a;
}

/// Returns the 16-bit number of a top-level element: its last two bytes, because walk.cpp checked
/// its length.
std::uint32_t number(const Precheck& in, std::uint32_t tag, std::uint32_t otherwise) {
  const auto found = std::find_if(in.elements.begin(), in.elements.end(),
                                  [&](const Range& r) { return r.tag == tag; });
  return found == in.elements.end() ? otherwise : u16(in, found->end - 2);
}

bool put_native(std::vector<std::byte>& out, const Precheck& in, std::uint64_t frame) {
  const std::uint64_t bits = number(in, kBitsAllocated, 16);
  const std::uint64_t bytes =
      std::uint64_t{in.rows} * in.columns * number(in, kSamples, 1) * ((bits + 7) / 8);
  const auto all = in.pixels.front();
  if (bits < 8 || (frame + 1) * bytes > all.size()) return false;
  const std::uint64_t padded = bytes + bytes % 2;
  put_header(out, in.syntax, kPixelData, bits > 8 ? "OW" : "OB",
             static_cast<std::uint32_t>(padded));
  const auto own = all.subspan(frame * bytes, bytes);
  out.insert(out.end(), own.begin(), own.end());
  out.resize(out.size() + (padded - bytes));
  return true;
}

void put_compressed(std::vector<std::byte>& out, const Precheck& in, std::uint64_t frame) {
  constexpr std::uint32_t kItem = 0xFFFEE000, kEnd = 0xFFFEE0DD, kUndefined = 0xFFFFFFFF;
  const std::span own = std::span(in.pixels).subspan(
      in.frame_fragments[frame], in.frame_fragments[frame + 1] - in.frame_fragments[frame]);
  std::size_t length = 0;
  for (const auto part : own) length += part.size();
  put_header(out, in.syntax, kPixelData, "OB", kUndefined);
  put_tag(out, kItem, false);
  put32(out, 0, false);  // empty offset table
  put_tag(out, kItem, false);
  put32(out, static_cast<std::uint32_t>(length), false);
  for (const auto part : own) out.insert(out.end(), part.begin(), part.end());
  put_tag(out, kEnd, false);
  put32(out, 0, false);
}

}  // namespace

std::vector<std::byte> frame_file(const Precheck& checked, std::uint64_t frame) {
  if (frame >= checked.frames || checked.pixels.empty()) return {};
  if (checked.encapsulated && frame + 1 >= checked.frame_fragments.size()) return {};
  // A class with functional groups does not apply to a single frame without them.
  const bool one_of_many = checked.frames > 1 || checked.has_groups;
  std::vector<std::byte> out(
      checked.plain.begin(),
      checked.plain.begin() + static_cast<std::ptrdiff_t>(checked.elements.empty()
                                                              ? checked.plain.size()
                                                              : checked.elements.front().begin));
  for (const Range& element : checked.elements) {
    if (element.tag == kFrames && one_of_many) continue;
    if (element.tag == kSopClass && one_of_many) {
      put_header(out, checked.syntax, kSopClass, "UI", kPlainClass.size());
      const auto* text = reinterpret_cast<const std::byte*>(kPlainClass.data());
      out.insert(out.end(), text, text + kPlainClass.size());
      continue;
    }
    out.insert(out.end(), checked.plain.begin() + static_cast<std::ptrdiff_t>(element.begin),
               checked.plain.begin() + static_cast<std::ptrdiff_t>(element.end));
  }
  if (checked.encapsulated) {
    put_compressed(out, checked, frame);
  } else if (!put_native(out, checked, frame)) {
    out.clear();
  }
  return out;
}

}  // namespace diaphane::dicom
