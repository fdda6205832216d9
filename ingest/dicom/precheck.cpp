#include "ingest/dicom/precheck.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <string_view>

#include "ingest/dicom/codestream.h"
#include "ingest/dicom/walk.h"

namespace diaphane::dicom {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::size_t kPreamble = 128;
constexpr std::string_view kExplicitLittle = "1.2.840.10008.1.2.1";
constexpr std::string_view kExplicitBig = "1.2.840.10008.1.2.2";
constexpr std::string_view kImplicitLittle = "1.2.840.10008.1.2";

std::uint32_t byte(Bytes in, std::size_t at) { return std::to_integer<std::uint32_t>(in[at]); }
std::uint32_t u16(Bytes in, std::size_t at) { return byte(in, at) | byte(in, at + 1) << 8; }
std::uint32_t u32(Bytes in, std::size_t at) { return u16(in, at) | u16(in, at + 2) << 16; }

Precheck refuse(FileState state, std::string text) {
  Precheck result;
  result.state = state;
  result.text = std::move(text);
  return result;
}

/// The File Meta Information (group 0002), which is always explicit little endian (DICOM PS3.10,
/// 7.1).
struct Meta {
  std::size_t end = 0;  ///< start of the data set
  std::string syntax;   ///< empty if not given
  bool broken = false;
};

Meta read_meta(Bytes file, std::size_t at) {
  Meta meta;
  while (at + 8 <= file.size() && u16(file, at) == 0x0002) {
    const std::uint32_t element = u16(file, at + 2);
    const char vr[] = {static_cast<char>(byte(file, at + 4)), static_cast<char>(byte(file, at + 5)),
                       0};
    const bool wide = std::string_view(vr) == "OB" || std::string_view(vr) == "UN";
    if (wide && at + 12 > file.size()) break;
    const std::uint64_t length = wide ? u32(file, at + 8) : u16(file, at + 6);
    at += wide ? 12 : 8;
    if (length > file.size() - at) {
      meta.broken = true;
      return meta;
    }
    if (element == 0x0010) {
      meta.syntax.assign(reinterpret_cast<const char*>(file.data()) + at, length);
      while (!meta.syntax.empty() && (meta.syntax.back() == '\0' || meta.syntax.back() == ' ')) {
        meta.syntax.pop_back();
      }
    }
    at += length;
  }
  meta.end = at;
  return meta;
}

/// Guesses the transfer syntax of a data set without a header from its first element. Returns
/// nullopt if it is not DICOM.
std::optional<std::string_view> guess_syntax(Bytes data) {
  if (data.size() < 8) return std::nullopt;
  const auto is_capital = [](std::uint32_t c) { return c >= 'A' && c <= 'Z'; };
  const bool names = is_capital(byte(data, 4)) && is_capital(byte(data, 5));
  if (names && u16(data, 0) == 0x0800 && byte(data, 2) <= 0x23) return kExplicitBig;
  if (u16(data, 0) != 0x0008 || u16(data, 2) > 0x2300) return std::nullopt;
  if (names) return kExplicitLittle;
  if (u32(data, 4) <= data.size() - 8) return kImplicitLittle;
  return std::nullopt;
}

/// The contents of a raw deflate stream (DICOM PS3.5, A.5), or the reason for refusing it.
struct Inflated {
  std::vector<std::byte> data;
  FileState state = FileState::kFit;
};

Inflated inflate_all(Bytes packed, std::uint64_t limit) {
  Inflated result;
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) {
    result.state = FileState::kTooLarge;
    return result;
  }
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data()));
  stream.avail_in = static_cast<uInt>(std::min<std::size_t>(packed.size(), UINT32_MAX));
  std::vector<std::byte> part(std::size_t{1} << 16);
  int code = Z_OK;
  while (code == Z_OK) {
    stream.next_out = reinterpret_cast<Bytef*>(part.data());
    stream.avail_out = static_cast<uInt>(part.size());
    code = inflate(&stream, Z_NO_FLUSH);
    const std::size_t got = part.size() - stream.avail_out;
    if (result.data.size() + got > limit) {
      result.state = FileState::kTooLarge;
      break;
    }
    result.data.insert(result.data.end(), part.begin(),
                       part.begin() + static_cast<std::ptrdiff_t>(got));
  }
  if (result.state == FileState::kFit && code != Z_STREAM_END) result.state = FileState::kDamaged;
  inflateEnd(&stream);
  return result;
}

/// Builds a file of the kept elements after a minimal header. `places` receives their ranges in it.
std::vector<std::byte> plain_file(Bytes data, const std::vector<Range>& kept,
                                  std::string_view syntax, std::vector<Range>& places) {
  std::string uid(syntax);
  if (uid.size() % 2 != 0) uid += '\0';
  std::string head(kPreamble, '\0');
  head += "DICM";
  const auto put = [&](const char* tag_vr, std::string_view value) {
    head.append(tag_vr, 6);
    head += static_cast<char>(value.size() & 0xff);
    head += static_cast<char>(value.size() >> 8);
    head += value;
  };
  const std::uint32_t group = static_cast<std::uint32_t>(uid.size()) + 8;
  put("\x02\x00\x00\x00UL", std::string{static_cast<char>(group), 0, 0, 0});
  put("\x02\x00\x10\x00UI", uid);
  std::size_t size = head.size();
  for (const Range& range : kept) size += range.end - range.begin;
  std::vector<std::byte> file(size);
  std::memcpy(file.data(), head.data(), head.size());
  std::size_t to = head.size();
  for (const Range& range : kept) {
    const std::size_t length = range.end - range.begin;
    std::memcpy(file.data() + to, data.data() + range.begin, length);
    places.push_back({range.tag, to, to + length});
    to += length;
  }
  return file;
}

/// Copies the values of functional groups into texts that own their bytes.
std::vector<GroupedText> texts_of(Bytes data, const std::vector<Range>& ranges) {
  std::vector<GroupedText> texts;
  texts.reserve(ranges.size());
  for (const Range& range : ranges) {
    texts.push_back(
        {range.tag, std::string(reinterpret_cast<const char*>(data.data()) + range.begin,
                                range.end - range.begin)});
  }
  return texts;
}

/// Returns a x b, or the largest number on overflow.
std::uint64_t times(std::uint64_t a, std::uint64_t b) {
  std::uint64_t product = 0;
  return __builtin_mul_overflow(a, b, &product) ? UINT64_MAX : product;
}

/// Returns whether a JPEG or JPEG 2000 image begins here.
bool begins_picture(Bytes part) {
  return part.size() >= 2 && part[0] == std::byte{0xFF} &&
         (part[1] == std::byte{0xD8} || part[1] == std::byte{0x4F});
}

/// Returns the entries of an offset table, of `bytes` bytes each, or an empty vector if it is not a
/// table for `count` frames.
std::vector<std::uint64_t> offsets_of(Bytes data, const Range& table, std::uint64_t count,
                                      std::size_t bytes) {
  std::vector<std::uint64_t> offsets;
  if (table.end - table.begin != times(count, bytes)) return offsets;
  for (std::size_t at = table.begin; at < table.end; at += bytes) {
    const std::uint64_t high = bytes == 8 ? u32(data, at + 4) : 0;
    offsets.push_back(high << 32 | u32(data, at));
  }
  return offsets;
}

/// Returns the index of the first fragment of each frame (1-based in `walked`, 0-based here),
/// followed by the number of fragments. Empty unless every offset points at a fragment, in order
/// from the first.
std::vector<std::size_t> firsts_by(const std::vector<std::uint64_t>& offsets,
                                   const Walked& walked) {
  std::vector<std::size_t> firsts;
  const auto& all = walked.fragments;
  std::size_t next = 1;
  for (const std::uint64_t offset : offsets) {
    while (next < all.size() && all[next].begin - all[1].begin < offset) ++next;
    if (next == all.size() || all[next].begin - all[1].begin != offset) return {};
    firsts.push_back(next++ - 1);
  }
  if (firsts.empty() || firsts.front() != 0) return {};
  firsts.push_back(all.size() - 1);
  return firsts;
}

/// Assigns fragments to frames (DICOM PS3.5, A.4): one each, all to the only frame, or as an offset
/// table specifies. Returns an empty vector if the assignment is ambiguous.
std::vector<std::size_t> firsts_of_frames(Bytes data, const Walked& walked,
                                          const Precheck& header) {
  const std::size_t fragments = walked.fragments.size() - 1;
  std::vector<std::size_t> firsts;
  if (fragments == header.frames) {
    for (std::size_t i = 0; i <= fragments; ++i) firsts.push_back(i);
    return firsts;
  }
  if (fragments < header.frames || header.syntax.packing == Packing::kRle) return firsts;
  if (header.frames == 1) return {0, fragments};
  firsts = firsts_by(offsets_of(data, walked.long_offsets, header.frames, 8), walked);
  if (!firsts.empty()) return firsts;
  return firsts_by(offsets_of(data, walked.fragments.front(), header.frames, 4), walked);
}

constexpr std::string_view kWhosePieces =
    "the fragments of the compressed images cannot be assigned to frames";

/// Checks compressed images against the header and notes which fragments belong to which frame.
std::optional<std::string_view> fault_of_fragments(Bytes data, const Walked& walked,
                                                   Precheck& header) {
  constexpr std::string_view kOtherNumber = "the number of images does not match the header";
  const PictureClaim claim{header.columns, header.rows, walked.samples.value_or(1),
                           walked.bits_allocated.value_or(16)};
  if (walked.fragments.size() < 2) return "compressed pixel data is missing";
  header.frame_fragments = firsts_of_frames(data, walked, header);
  if (header.frame_fragments.empty()) {
    const bool in_pieces = walked.fragments.size() - 1 > header.frames && header.frames > 0 &&
                           header.syntax.packing != Packing::kRle;
    return in_pieces ? kWhosePieces : kOtherNumber;
  }
  std::vector<std::byte> joined;
  for (std::size_t frame = 0; frame + 1 < header.frame_fragments.size(); ++frame) {
    const std::size_t first = header.frame_fragments[frame];
    const std::size_t count = header.frame_fragments[frame + 1] - first;
    const auto fragment = [&](std::size_t i) {
      const Range& at = walked.fragments[1 + first + i];
      return data.subspan(at.begin, at.end - at.begin);
    };
    joined.clear();
    for (std::size_t i = 0; count > 1 && i < count; ++i) {
      const Bytes part = fragment(i);
      if (begins_picture(part) && i > 0) return kOtherNumber;
      joined.insert(joined.end(), part.begin(), part.end());
    }
    if (auto fault = fault_of(count > 1 ? Bytes(joined) : fragment(0), header.syntax, claim))
      return fault;
  }
  return std::nullopt;
}

/// Checks the image against the limits and against the bytes of the file.
void check_pixels(Bytes data, const Walked& walked, const Limits& limits, Precheck& result) {
  result.rows = walked.rows.value_or(0);
  result.columns = walked.columns.value_or(0);
  result.frames = walked.frames.value_or(1);
  result.has_pixels = walked.has_pixels;
  const std::uint64_t bits = walked.bits_allocated.value_or(16);
  const std::uint64_t samples = walked.samples.value_or(1);
  std::uint64_t frame =
      times(times(result.rows, result.columns), std::max(samples, std::uint64_t{1}));
  frame = times(frame, std::max<std::uint64_t>((bits + 7) / 8, 1));
  const std::uint64_t bytes = times(frame, result.frames);
  const auto refuse_with = [&](FileState state, std::string_view text) {
    result.state = state;
    result.text = text;
  };
  if (frame > limits.frame_bytes || bytes > limits.pixel_bytes) {
    return refuse_with(FileState::kTooLarge, "the image is larger than allowed");
  }
  if (result.frames > limits.frames) {
    return refuse_with(FileState::kTooLarge, "there are more frames than allowed");
  }
  if (!walked.has_pixels) return;
  // An image needs these fields. GDCM aborts on a header or frame without them, so it never gets
  // such a file.
  if (result.rows == 0 || result.columns == 0 || samples == 0) {
    return refuse_with(FileState::kDamaged, "the file has pixels but no description of the image");
  }
  if (!walked.encapsulated) {
    if (result.syntax.packing != Packing::kNative) {
      return refuse_with(FileState::kDamaged, "compressed pixel data is missing");
    }
    if (bits >= 8 && walked.native.end - walked.native.begin < bytes) {
      return refuse_with(FileState::kDamaged, "pixel data is missing");
    }
    return;
  }
  if (result.syntax.packing == Packing::kNative) {
    return refuse_with(FileState::kDamaged, "the pixel data uses an unknown compression");
  }
  if (const auto fault = fault_of_fragments(data, walked, result)) {
    return refuse_with(*fault == kWhosePieces ? FileState::kUnsupported : FileState::kDamaged,
                       *fault);
  }
  result.unpacked_bytes = std::max(result.unpacked_bytes, bytes);
}

/// Decompresses a deflated data set if its size is allowed.
void inflate_within(const Limits& limits, OpenedFile& result) {
  const std::uint64_t most =
      limits.inflated_free + times(limits.inflated_ratio, result.data.size());
  Inflated inflated = inflate_all(result.data, std::min(limits.inflated_bytes, most));
  result.unpacked_bytes = inflated.data.size();
  result.state = inflated.state;
  if (inflated.state == FileState::kFit) {
    result.inflated = std::move(inflated.data);
    result.data = result.inflated;
  } else {
    result.text = inflated.state == FileState::kTooLarge
                      ? "the decompressed file is larger than allowed"
                      : "the file cannot be decompressed";
  }
}

/// Copies what a volume needs from a fit data set to `result`.
void take_contents(Bytes data, const Walked& walked, Precheck& result) {
  result.has_lookup_table = walked.has_lookup_table;
  if (result.syntax.deflated)
    result.syntax = *find_syntax(kExplicitLittle);  // because `plain` is inflated
  result.plain = plain_file(data, walked.kept, result.syntax.uid, result.elements);
  result.encapsulated = walked.encapsulated;
  const auto bytes_of = [&](const Range& at) { return data.subspan(at.begin, at.end - at.begin); };
  if (walked.has_pixels && !walked.encapsulated) result.pixels.push_back(bytes_of(walked.native));
  for (std::size_t i = 1; i < walked.fragments.size(); ++i) {
    result.pixels.push_back(bytes_of(walked.fragments[i]));
  }
  result.has_groups = walked.has_groups;
  result.shared = texts_of(data, walked.shared);
  for (const auto& frame : walked.each) result.each.push_back(texts_of(data, frame));
}

}  // namespace

OpenedFile open_file(Bytes file, const Limits& limits) {
  OpenedFile result;
  const auto refused = [&](FileState state, std::string text) {
    result.state = state;
    result.text = std::move(text);
    return std::move(result);
  };
  if (file.size() > limits.file_bytes) {
    return refused(FileState::kTooLarge, "the file is too large");
  }
  const bool with_preamble =
      file.size() >= kPreamble + 4 && std::memcmp(file.data() + kPreamble, "DICM", 4) == 0;
  const bool bare_meta = !with_preamble && file.size() >= 8 && u16(file, 0) == 0x0002 &&
                         u16(file, 2) <= 0x0102 && byte(file, 4) >= 'A' && byte(file, 4) <= 'Z';
  Meta meta;
  if (with_preamble || bare_meta) meta = read_meta(file, with_preamble ? kPreamble + 4 : 0);
  if (meta.broken) return refused(FileState::kDamaged, "the file is incomplete");
  result.data = file.subspan(meta.end);
  if (meta.syntax.empty()) {
    const auto guessed = guess_syntax(result.data);
    if (!guessed) {
      return with_preamble ? refused(FileState::kDamaged, "the file has a header but no data")
                           : refused(FileState::kNotDicom, "this is not a DICOM file");
    }
    meta.syntax = *guessed;
  }
  const auto syntax = find_syntax(meta.syntax);
  if (!syntax) {
    return refused(FileState::kUnsupported, "the compression of the images is not supported (" +
                                                syntax_name(meta.syntax) + ")");
  }
  result.syntax = *syntax;
  if (syntax->deflated) inflate_within(limits, result);
  return result;
}

Precheck precheck(Bytes file, const Limits& limits) {
  OpenedFile opened = open_file(file, limits);
  Precheck result;
  result.unpacked_bytes = opened.unpacked_bytes;
  // A refused file also reports how many bytes were unpacked.
  const auto give_up = [&](FileState state, std::string text) {
    Precheck refusal = refuse(state, std::move(text));
    refusal.unpacked_bytes = result.unpacked_bytes;
    return refusal;
  };
  if (opened.state != FileState::kFit) return give_up(opened.state, std::move(opened.text));
  result.state = FileState::kFit;
  result.syntax = opened.syntax;
  const Bytes data = opened.data;
  result.inflated = std::move(opened.inflated);
  const Walked walked = walk(data, result.syntax.explicit_vr, result.syntax.big_endian, limits);
  if (walked.state != FileState::kFit) return give_up(walked.state, walked.text);
  check_pixels(data, walked, limits, result);
  if (result.state != FileState::kFit) return give_up(result.state, std::move(result.text));
  take_contents(data, walked, result);
  return result;
}

}  // namespace diaphane::dicom
