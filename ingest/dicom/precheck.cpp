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

/// The group 0002 of a file, always explicit little endian (DICOM PS3.10, 7.1).
struct Meta {
  std::size_t end = 0;  ///< where the data set begins
  std::string syntax;   ///< empty: it does not say
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

/// What a data set without a header is written in, judged by its first element; nothing: not DICOM.
std::optional<std::string_view> guess_syntax(Bytes data) {
  if (data.size() < 8 || u16(data, 0) != 0x0008 || u16(data, 2) > 0x2300) return std::nullopt;
  const auto is_capital = [](std::uint32_t c) { return c >= 'A' && c <= 'Z'; };
  if (is_capital(byte(data, 4)) && is_capital(byte(data, 5))) return kExplicitLittle;
  if (u32(data, 4) <= data.size() - 8) return kImplicitLittle;
  return std::nullopt;
}

/// Raw deflate (DICOM PS3.5, A.5), never more than `limit` bytes.
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

/// A file of the elements kept, behind the shortest header.
std::vector<std::byte> plain_file(Bytes data, const std::vector<Range>& kept,
                                  std::string_view syntax) {
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
  auto to = file.begin() + static_cast<std::ptrdiff_t>(head.size());
  for (const Range& range : kept) {
    const Bytes part = data.subspan(range.begin, range.end - range.begin);
    to = std::copy(part.begin(), part.end(), to);
  }
  return file;
}

/// a x b, or the largest number when that does not fit.
std::uint64_t times(std::uint64_t a, std::uint64_t b) {
  std::uint64_t product = 0;
  return __builtin_mul_overflow(a, b, &product) ? UINT64_MAX : product;
}

/// The picture against the limits and against the bytes that are there.
void check_pixels(const Walked& walked, const Limits& limits, Precheck& result) {
  result.rows = walked.rows.value_or(0);
  result.columns = walked.columns.value_or(0);
  result.frames = walked.frames.value_or(1);
  result.has_pixels = walked.has_pixels;
  const std::uint64_t bits = walked.bits_allocated.value_or(16);
  std::uint64_t picture = times(result.rows, result.columns);
  picture = times(picture, walked.samples.value_or(1));
  picture = times(picture, result.frames);
  const std::uint64_t bytes = times(picture, std::max<std::uint64_t>((bits + 7) / 8, 1));
  const auto refuse_with = [&](FileState state, const char* text) {
    result.state = state;
    result.text = text;
  };
  if (bytes > limits.pixel_bytes) {
    return refuse_with(FileState::kTooLarge, "the picture is larger than is allowed");
  }
  if (!walked.has_pixels) return;
  if (!walked.encapsulated) {
    if (result.syntax.packing != Packing::kNative) {
      return refuse_with(FileState::kDamaged, "compressed pixels are missing");
    }
    if (bits >= 8 && walked.pixel_length < bytes) {
      return refuse_with(FileState::kDamaged, "pixels are missing");
    }
    return;
  }
  if (result.syntax.packing == Packing::kNative) {
    return refuse_with(FileState::kDamaged, "pixels are compressed in an unknown way");
  }
  if (result.syntax.packing == Packing::kRle) return;
  const auto inside = picture_size(walked.first_fragment, result.syntax.packing);
  if (!inside) return refuse_with(FileState::kDamaged, "the compressed picture is broken");
  if (inside->width != result.columns || inside->height != result.rows ||
      inside->components != walked.samples.value_or(1)) {
    return refuse_with(FileState::kDamaged,
                       "the compressed picture has another size than it should");
  }
}

}  // namespace

Precheck precheck(Bytes file, const Limits& limits) {
  if (file.size() > limits.file_bytes) return refuse(FileState::kTooLarge, "the file is too large");
  const bool with_preamble =
      file.size() >= kPreamble + 4 && std::memcmp(file.data() + kPreamble, "DICM", 4) == 0;
  const bool bare_meta = !with_preamble && file.size() >= 8 && u16(file, 0) == 0x0002 &&
                         u16(file, 2) <= 0x0102 && byte(file, 4) >= 'A' && byte(file, 4) <= 'Z';
  Meta meta;
  if (with_preamble || bare_meta) meta = read_meta(file, with_preamble ? kPreamble + 4 : 0);
  if (meta.broken) return refuse(FileState::kDamaged, "the file ends too early");
  Bytes data = file.subspan(meta.end);
  if (meta.syntax.empty()) {
    const auto guessed = guess_syntax(data);
    if (!guessed) {
      return with_preamble ? refuse(FileState::kDamaged, "the file has a header and no data")
                           : refuse(FileState::kNotDicom, "this is not a DICOM file");
    }
    meta.syntax = *guessed;
  }
  const auto syntax = find_syntax(meta.syntax);
  if (!syntax) {
    return refuse(FileState::kUnsupported,
                  "the pictures are compressed in a way that is not supported (" +
                      syntax_name(meta.syntax) + ")");
  }
  Precheck result;
  result.state = FileState::kFit;
  result.syntax = *syntax;
  Inflated inflated;
  if (syntax->deflated) {
    inflated = inflate_all(data, limits.inflated_bytes);
    if (inflated.state == FileState::kTooLarge) {
      return refuse(FileState::kTooLarge, "the file unpacks to more than is allowed");
    }
    if (inflated.state != FileState::kFit) {
      return refuse(FileState::kDamaged, "the file cannot be unpacked");
    }
    data = inflated.data;
  }
  const Walked walked = walk(data, syntax->explicit_vr, syntax->big_endian, limits);
  if (walked.state != FileState::kFit) return refuse(walked.state, walked.text);
  check_pixels(walked, limits, result);
  if (result.state != FileState::kFit) return refuse(result.state, std::move(result.text));
  result.has_lookup_table = walked.has_lookup_table;
  result.plain = plain_file(data, walked.kept, syntax->deflated ? kExplicitLittle : syntax->uid);
  return result;
}

}  // namespace diaphane::dicom
