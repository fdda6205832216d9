#include "renderd/encode/frame_mark.h"

#include <algorithm>

namespace diaphane::render {
namespace {

constexpr std::uint32_t kCells = 40;
constexpr std::uint64_t kSync = 0b10;
constexpr int kChecksumBits = 8;
constexpr int kNumberBits = 24;
constexpr int kQuietBits = 6;

std::uint64_t checksum(std::uint64_t number) {
  return (number >> 16 ^ number >> 8 ^ number) & 0xff;
}

// Returns the cells as bits, with the first cell in the highest of 40.
std::uint64_t cells_of(std::uint64_t number) {
  return ((kSync << kNumberBits | number) << kChecksumBits | checksum(number)) << kQuietBits;
}

std::uint32_t edge(const PictureRgb8& picture, std::uint32_t cell) {
  return static_cast<std::uint32_t>(std::uint64_t{cell} * picture.size.width / kCells);
}

std::uint32_t rows(const PictureRgb8& picture) {
  return std::min(picture.size.width / kCells, picture.size.height);
}

}  // namespace

void draw_frame_mark(PictureRgb8& picture, std::uint64_t input_seq) {
  const std::uint64_t cells = cells_of(input_seq & ((1U << kNumberBits) - 1));
  for (std::uint32_t y = 0; y < rows(picture); ++y) {
    std::uint8_t* row = picture.pixels.data() + std::size_t{3} * y * picture.size.width;
    for (std::uint32_t cell = 0; cell < kCells; ++cell) {
      const bool white = (cells >> (kCells - 1 - cell) & 1) != 0;
      std::fill(row + std::size_t{3} * edge(picture, cell),
                row + std::size_t{3} * edge(picture, cell + 1), white ? 255 : 0);
    }
  }
}

std::optional<std::uint32_t> read_frame_mark(const PictureRgb8& picture) {
  if (rows(picture) == 0) return std::nullopt;
  std::uint64_t cells = 0;
  const std::size_t row = std::size_t{rows(picture) / 2} * picture.size.width;
  for (std::uint32_t cell = 0; cell < kCells; ++cell) {
    const std::size_t middle = (edge(picture, cell) + edge(picture, cell + 1)) / 2;
    const std::uint8_t green = picture.pixels[3 * (row + middle) + 1];
    cells = cells << 1 | (green >= 128 ? 1 : 0);
  }
  const auto number =
      static_cast<std::uint32_t>(cells >> (kChecksumBits + kQuietBits) & ((1U << kNumberBits) - 1));
  if (cells != cells_of(number)) return std::nullopt;
  return number;
}

}  // namespace diaphane::render
