#include "renderd/composite/wire.h"

#include <algorithm>

namespace diaphane::render {
namespace {

constexpr std::size_t kPixelBytes = 10;
constexpr std::size_t kGuidesBytes = 6;

void put_number(std::string& to, std::size_t number) {
  for (; number >= 0x80; number >>= 7) to.push_back(static_cast<char>(number | 0x80));
  to.push_back(static_cast<char>(number));
}

/// Reads a varint. Returns false if there is none or it has more than 35 bits.
bool take_number(std::string_view& from, std::size_t& number) {
  number = 0;
  for (unsigned shift = 0; shift < 35 && !from.empty(); shift += 7) {
    const auto byte = static_cast<unsigned char>(from.front());
    from.remove_prefix(1);
    number |= std::size_t{byte & 0x7fU} << shift;
    if ((byte & 0x80U) == 0) return true;
  }
  return false;
}

void put_pixel(std::string& to, const PackedPixel& p) {
  for (const std::uint16_t mean : p.mean) {
    to.push_back(static_cast<char>(mean & 0xffU));
    to.push_back(static_cast<char>(mean >> 8));
  }
  for (const std::uint8_t half : p.half) to.push_back(static_cast<char>(half));
  to.push_back(static_cast<char>(p.state));
}

PackedPixel pixel_at(const char* bytes) {
  const auto byte = [bytes](int i) { return static_cast<unsigned char>(bytes[i]); };
  PackedPixel p{};
  for (int c = 0; c < 3; ++c) {
    p.mean[c] = static_cast<std::uint16_t>(byte(2 * c) | byte(2 * c + 1) << 8);
    p.half[c] = byte(6 + c);
  }
  p.state = byte(9);
  return p;
}

}  // namespace

std::string pixels_to_wire(const PackedPixel* pixels, std::size_t count) {
  std::string out;
  out.reserve(count * kPixelBytes + 16);
  std::size_t begin = 0;  // first pixel that is not written yet
  const auto flush = [&](std::size_t end) {
    if (end == begin) return;
    put_number(out, 2 * (end - begin));
    for (; begin < end; ++begin) put_pixel(out, pixels[begin]);
  };
  for (std::size_t i = 0; i < count;) {
    std::size_t same = i + 1;
    while (same < count && pixels[same] == pixels[i]) ++same;
    // A run interrupts the pixels before it, which pays off from a length of three.
    if (same - i >= 3) {
      flush(i);
      put_number(out, 2 * (same - i) + 1);
      put_pixel(out, pixels[i]);
      begin = same;
    }
    i = same;
  }
  flush(count);
  return out;
}

Result<std::vector<PackedPixel>> pixels_from_wire(std::string_view bytes, std::size_t count) {
  const auto wrong = [] {
    return fail(ErrorCode::kInvalid, "the pixel data is invalid", "pixels");
  };
  std::vector<PackedPixel> pixels;
  pixels.reserve(count);
  while (!bytes.empty()) {
    std::size_t number = 0;
    if (!take_number(bytes, number)) return wrong();
    const std::size_t n = number / 2;
    const bool run = number % 2 == 1;
    const std::size_t stored = run ? 1 : n;
    if (n > count - pixels.size() || bytes.size() / kPixelBytes < stored) return wrong();
    if (run) {
      pixels.insert(pixels.end(), n, pixel_at(bytes.data()));
    } else {
      for (std::size_t i = 0; i < n; ++i) {
        pixels.push_back(pixel_at(bytes.data() + kPixelBytes * i));
      }
    }
    bytes.remove_prefix(kPixelBytes * stored);
  }
  if (pixels.size() != count) return wrong();
  return pixels;
}

std::string guides_to_wire(const std::vector<PackedGuides>& guides) {
  std::string out;
  out.reserve(guides.size() * kGuidesBytes);
  for (const PackedGuides& one : guides) {
    for (const std::uint16_t word : one.words) {
      out.push_back(static_cast<char>(word & 0xffU));
      out.push_back(static_cast<char>(word >> 8));
    }
  }
  return out;
}

Result<std::vector<PackedGuides>> guides_from_wire(std::string_view bytes, std::size_t count) {
  if (bytes.empty()) return std::vector<PackedGuides>{};
  if (bytes.size() != count * kGuidesBytes) {
    return fail(ErrorCode::kInvalid, "the guide data is invalid", "guides");
  }
  std::vector<PackedGuides> guides(count);
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t w = 0; w < 3; ++w) {
      const std::size_t at = kGuidesBytes * i + 2 * w;
      guides[i].words[w] = static_cast<std::uint16_t>(byte(at) | byte(at + 1) << 8);
    }
  }
  return guides;
}

std::vector<FilmPart> in_bands(FilmPart part, std::size_t most_bytes) {
  const std::size_t unit = std::size_t{kPixelBytes} * part.width * kShareRows;
  const auto rows = static_cast<std::uint32_t>(
      kShareRows * std::max<std::size_t>(1, most_bytes / std::max<std::size_t>(1, unit)));
  std::vector<FilmPart> bands;
  if (part.rows <= rows) {
    bands.push_back(std::move(part));
    return bands;
  }
  for (std::uint32_t first = 0; first < part.rows; first += rows) {
    FilmPart band;
    band.width = part.width;
    band.first_row = part.first_row + first;
    band.rows = std::min(rows, part.rows - first);
    band.samples = part.samples;
    const auto begin =
        part.pixels.begin() + static_cast<std::ptrdiff_t>(std::size_t{first} * part.width);
    band.pixels.assign(begin,
                       begin + static_cast<std::ptrdiff_t>(std::size_t{band.rows} * part.width));
    if (!part.guides.empty()) {
      const auto from =
          part.guides.begin() + static_cast<std::ptrdiff_t>(std::size_t{first} * part.width);
      band.guides.assign(from,
                         from + static_cast<std::ptrdiff_t>(std::size_t{band.rows} * part.width));
    }
    bands.push_back(std::move(band));
  }
  return bands;
}

}  // namespace diaphane::render
