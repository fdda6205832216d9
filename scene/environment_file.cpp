#include "scene/environment_file.h"

#include <algorithm>
#include <charconv>
#include <cstring>

#include "common/try.h"

namespace diaphane::scene {
namespace {

constexpr std::string_view kHead = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ";

tl::unexpected<Error> not_stored() {
  return fail(ErrorCode::kInvalid, "is not an environment as Diaphane stores it");
}

struct Head {
  std::array<std::uint32_t, 2> size{};
  std::size_t bytes = 0;  ///< offset of the first pixel
};

Result<Head> head_of(std::string_view file) {
  if (!file.starts_with(kHead)) return not_stored();
  Head head;
  const char* const end = file.data() + file.size();
  const auto height = std::from_chars(file.data() + kHead.size(), end, head.size[1]);
  constexpr std::string_view kBetween = " +X ";
  if (height.ec != std::errc() || end - height.ptr < std::ssize(kBetween) ||
      std::memcmp(height.ptr, kBetween.data(), kBetween.size()) != 0) {
    return not_stored();
  }
  const auto width = std::from_chars(height.ptr + kBetween.size(), end, head.size[0]);
  if (width.ec != std::errc() || width.ptr == end || *width.ptr != '\n') return not_stored();
  head.bytes = static_cast<std::size_t>(width.ptr + 1 - file.data());
  const auto [w, h] = head.size;
  if (w < 1 || w > kMostEnvironmentWidth || h < 1 || h > kMostEnvironmentHeight)
    return not_stored();
  if (file.size() - head.bytes != std::size_t{4} * w * h) return not_stored();
  return head;
}

}  // namespace

Rgbe to_rgbe(float r, float g, float b) {
  const float brightest = std::max({r, g, b});
  int exponent = 0;
  std::frexp(brightest, &exponent);
  // Rounding can reach the next power of two.
  if (std::lround(std::ldexp(brightest, 8 - exponent)) > 255) ++exponent;
  if (!(brightest > 0) || exponent < -127) return {};
  exponent = std::min(exponent, kMostExponent - 128);
  const auto mantissa = [exponent](float c) {
    return static_cast<std::uint8_t>(
        std::clamp(std::lround(std::ldexp(c, 8 - exponent)), 0L, 255L));
  };
  return {mantissa(r), mantissa(g), mantissa(b), static_cast<std::uint8_t>(exponent + 128)};
}

Result<std::array<std::uint32_t, 2>> environment_size(std::string_view file) {
  const auto head = head_of(file);
  DIAPHANE_TRY(head);
  return head->size;
}

Result<EnvironmentPicture> read_environment(std::string_view file) {
  const auto head = head_of(file);
  DIAPHANE_TRY(head);
  EnvironmentPicture picture{head->size[0], head->size[1], {}};
  picture.pixels.resize(std::size_t{picture.width} * picture.height);
  std::memcpy(picture.pixels.data(), file.data() + head->bytes, 4 * picture.pixels.size());
  const bool bright =
      std::ranges::any_of(picture.pixels, [](const Rgbe& p) { return p[3] > kMostExponent; });
  if (bright) return not_stored();
  return picture;
}

std::string write_environment(const EnvironmentPicture& picture) {
  std::string file(kHead);
  file += std::to_string(picture.height) + " +X " + std::to_string(picture.width) + "\n";
  file.append(reinterpret_cast<const char*>(picture.pixels.data()), 4 * picture.pixels.size());
  return file;
}

}  // namespace diaphane::scene
