#include "renderd/cli/picture_file.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#ifdef DIAPHANE_HAVE_PNG
#include <png.h>
#endif

namespace diaphane::render::cli {

std::optional<PictureFormat> picture_format(std::string_view path) {
  const auto ends_with = [&](std::string_view ending) {
    if (path.size() <= ending.size()) return false;
    return std::equal(ending.begin(), ending.end(), path.end() - std::ssize(ending),
                      [](char a, char b) { return a == (b >= 'A' && b <= 'Z' ? b + 32 : b); });
  };
  if (ends_with(".png")) return PictureFormat::kPng;
  if (ends_with(".exr")) return PictureFormat::kExr;
  if (ends_with(".ppm")) return PictureFormat::kPpm;
  return std::nullopt;
}

std::optional<std::string> unwritable_picture(std::string_view path) {
  const auto format = picture_format(path);
  if (!format) return "the name of the picture must end in .png, .exr or .ppm";
#ifndef DIAPHANE_HAVE_PNG
  if (*format == PictureFormat::kPng) return "this program was built without libpng: use .ppm";
#endif
#ifndef DIAPHANE_HAVE_EXR
  if (*format == PictureFormat::kExr) return "this program was built without tinyexr";
#endif
  return std::nullopt;
}

Result<std::string> encode_png([[maybe_unused]] const PictureRgb8& picture) {
#ifdef DIAPHANE_HAVE_PNG
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = picture.size.width;
  image.height = picture.size.height;
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (!png_image_write_to_memory(&image, bytes.data(), &size, 0, picture.pixels.data(), 0,
                                 nullptr)) {
    return fail(ErrorCode::kInternal, std::string("libpng: ") + image.message);
  }
  bytes.resize(size);
  return bytes;
#else
  return fail(ErrorCode::kUnsupported, "this program was built without libpng");
#endif
}

std::string encode_ppm(const PictureRgb8& picture) {
  std::string bytes = "P6\n" + std::to_string(picture.size.width) + " " +
                      std::to_string(picture.size.height) + "\n255\n";
  bytes.append(picture.pixels.begin(), picture.pixels.end());
  return bytes;
}

Result<void> write_file(const std::string& path, std::string_view bytes) {
  const std::string temporary = path + ".tmp-" + std::to_string(::getpid());
  const auto failed = [&](const char* doing) {
    const std::string why = std::strerror(errno);
    std::remove(temporary.c_str());
    return fail(ErrorCode::kForbidden, std::string("cannot ") + doing + " " + path + ": " + why);
  };
  std::FILE* file = std::fopen(temporary.c_str(), "wb");
  if (!file) return failed("create");
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  if (std::fclose(file) != 0 || !written) return failed("write");
  if (std::rename(temporary.c_str(), path.c_str()) != 0) return failed("rename to");
  return {};
}

}  // namespace diaphane::render::cli
