#include "api/studies/picture_check.h"

#include <png.h>
#include <turbojpeg.h>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace diaphane::api {
namespace {

constexpr std::size_t kMostPictureBytes = 524'288;  ///< migrations/0028
constexpr std::uint32_t kMostSide = 4096;

tl::unexpected<Error> no_picture() {
  return fail(ErrorCode::kInvalid, "is not a JPEG or PNG picture that can be read", "picture");
}

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (const char c : bytes) value = value << 8 | static_cast<unsigned char>(c);
  return value;
}

/// Copies the chunks that the pixels need, and those of colour.
Result<std::string> strip_png(std::string_view file) {
  constexpr std::size_t kSignature = 8, kFrame = 12;
  constexpr std::array<std::string_view, 9> kKept{"IHDR", "PLTE", "tRNS", "IDAT", "IEND",
                                                  "gAMA", "cHRM", "sRGB", "sBIT"};
  std::string kept(file.substr(0, kSignature));
  for (std::size_t at = kSignature; at < file.size();) {
    if (file.size() - at < kFrame) return no_picture();
    const std::size_t length = big_endian(file.substr(at, 4));
    if (length > file.size() - at - kFrame) return no_picture();
    const std::string_view type = file.substr(at + 4, 4);
    for (const std::string_view one : kKept) {
      if (type == one) kept += file.substr(at, length + kFrame);
    }
    if (type == "IEND") return kept;  // what follows is no part of the picture
    at += length + kFrame;
  }
  return no_picture();
}

/// Copies the segments that the pixels need: without comments, and of the application segments only
/// JFIF and Adobe's, which define the colours.
Result<std::string> strip_jpeg(std::string_view file) {
  constexpr unsigned char kComment = 0xfe, kFirstApp = 0xe0, kLastApp = 0xef, kAdobe = 0xee;
  constexpr unsigned char kScan = 0xda, kEnd = 0xd9;
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(file[at]); };
  std::string kept(file.substr(0, 2));
  std::size_t at = 2;
  while (at + 4 <= file.size()) {
    if (byte(at) != 0xff) return no_picture();
    const unsigned char marker = byte(at + 1);
    if (marker == kEnd) return kept + "\xff\xd9";
    if (marker == 0xff) {  // a fill byte
      ++at;
      continue;
    }
    const std::size_t length = big_endian(file.substr(at + 2, 2));
    if (length < 2 || length > file.size() - at - 2) return no_picture();
    std::size_t end = at + 2 + length;
    const bool dropped = marker == kComment || (marker > kFirstApp && marker <= kLastApp && marker != kAdobe);
    // The data of a scan continues to the next marker that is neither stuffing nor a restart.
    while (marker == kScan && end + 1 < file.size()) {
      const unsigned char next = byte(end + 1);
      if (byte(end) == 0xff && next != 0 && (next < 0xd0 || next > 0xd7)) break;
      ++end;
    }
    if (!dropped) kept += file.substr(at, end - at);
    at = end;
  }
  if (at + 2 == file.size() && byte(at) == 0xff && byte(at + 1) == kEnd) return kept + "\xff\xd9";
  return no_picture();
}

bool decodes_as_png(const std::string& file) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  const std::unique_ptr<png_image, decltype(&png_image_free)> freed(&image, png_image_free);
  if (png_image_begin_read_from_memory(&image, file.data(), file.size()) == 0) return false;
  if (image.width > kMostSide || image.height > kMostSide) return false;
  image.format = PNG_FORMAT_RGB;
  std::vector<unsigned char> pixels(PNG_IMAGE_SIZE(image));
  const png_color white{255, 255, 255};
  return png_image_finish_read(&image, &white, pixels.data(), 0, nullptr) != 0;
}

bool decodes_as_jpeg(const std::string& file) {
  const std::unique_ptr<void, decltype(&tjDestroy)> decoder(tjInitDecompress(), tjDestroy);
  const auto* bytes = reinterpret_cast<const unsigned char*>(file.data());
  int width = 0, height = 0, sampling = 0, colours = 0;
  if (!decoder || tjDecompressHeader3(decoder.get(), bytes, file.size(), &width, &height, &sampling,
                                      &colours) != 0) {
    return false;
  }
  const auto most = static_cast<int>(kMostSide);
  if (width < 1 || height < 1 || width > most || height > most) return false;
  std::vector<unsigned char> pixels(static_cast<std::size_t>(width) *
                                    static_cast<std::size_t>(height) * 3);
  // The flag refuses a progressive picture with absurdly many scans, which takes minutes.
  return tjDecompress2(decoder.get(), bytes, file.size(), pixels.data(), width, 0, height, TJPF_RGB,
                       TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS) == 0;
}

}  // namespace

Result<CheckedPicture> check_picture(std::string_view file) {
  if (file.size() > kMostPictureBytes) {
    return fail(ErrorCode::kInvalid, "must have at most 512 KiB", "picture");
  }
  if (file.starts_with("\x89PNG\r\n\x1a\n")) {
    auto kept = strip_png(file);
    if (!kept || !decodes_as_png(*kept)) return no_picture();
    return CheckedPicture{"image/png", *std::move(kept)};
  }
  if (file.starts_with("\xff\xd8")) {
    auto kept = strip_jpeg(file);
    if (!kept || !decodes_as_jpeg(*kept)) return no_picture();
    return CheckedPicture{"image/jpeg", *std::move(kept)};
  }
  return no_picture();
}

}  // namespace diaphane::api
