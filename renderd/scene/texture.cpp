#include "renderd/scene/texture.h"

#include <cmath>
#include <string>

#include "common/try.h"

#if defined(DIAPHANE_HAVE_PNG)
#include <png.h>
#endif
#if defined(DIAPHANE_HAVE_JPEG)
#include <turbojpeg.h>

#include <memory>
#endif

namespace diaphane::render {
namespace {

constexpr std::string_view kPngHead = "\x89PNG\r\n\x1a\n";
constexpr std::string_view kJpegHead = "\xff\xd8\xff";

tl::unexpected<Error> no_picture() {
  return fail(ErrorCode::kInvalid, "must be a PNG or JPEG picture");
}
tl::unexpected<Error> damaged() { return fail(ErrorCode::kInvalid, "is a corrupted picture"); }
[[maybe_unused]] tl::unexpected<Error> left_out(const char* format) {
  return fail(ErrorCode::kUnsupported,
              std::string("is a ") + format +
                  " picture, but this program was built without support for it");
}

Result<TextureSize> small_enough(std::uint32_t width, std::uint32_t height) {
  if (width == 0 || height == 0) return no_picture();
  if (width > kLongestTexture || height > kLongestTexture) {
    return fail(ErrorCode::kInvalid, "must be at most 4096 x 4096 pixels");
  }
  return TextureSize{width, height};
}

#if defined(DIAPHANE_HAVE_PNG)
/// libpng's reader, freed with its owner.
struct PngReader {
  png_image image{};

  PngReader() { image.version = PNG_IMAGE_VERSION; }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_image_free(&image); }
  bool begin(std::string_view file) {
    return png_image_begin_read_from_memory(&image, file.data(), file.size()) != 0;
  }
};

Result<TextureSize> png_size(std::string_view file) {
  PngReader reader;
  if (!reader.begin(file)) return no_picture();
  return small_enough(reader.image.width, reader.image.height);
}

Result<TexturePicture> decode_png(std::string_view file) {
  PngReader reader;
  if (!reader.begin(file)) return no_picture();
  const auto size = small_enough(reader.image.width, reader.image.height);
  DIAPHANE_TRY(size);
  reader.image.format = PNG_FORMAT_RGB;
  TexturePicture picture{*size, std::vector<std::uint8_t>(PNG_IMAGE_SIZE(reader.image)), {}};
  const png_color black{};
  if (png_image_finish_read(&reader.image, &black, picture.rgb.data(), 0, nullptr) == 0) {
    return damaged();
  }
  return picture;
}
#else
Result<TextureSize> png_size(std::string_view) { return left_out("PNG"); }
Result<TexturePicture> decode_png(std::string_view) { return left_out("PNG"); }
#endif

#if defined(DIAPHANE_HAVE_JPEG)
class JpegReader {
 public:
  JpegReader() : handle_(tjInitDecompress(), tjDestroy) {}

  Result<TextureSize> size(std::string_view file) {
    int width = 0, height = 0, subsampling = 0, colours = 0;
    if (!handle_ ||
        tjDecompressHeader3(handle_.get(), bytes(file), static_cast<unsigned long>(file.size()),
                            &width, &height, &subsampling, &colours) != 0) {
      return no_picture();
    }
    return small_enough(static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height));
  }

  Result<TexturePicture> decode(std::string_view file) {
    const auto known = size(file);
    DIAPHANE_TRY(known);
    TexturePicture picture{
        *known, std::vector<std::uint8_t>(std::size_t{3} * known->width * known->height), {}};
    // The limit of scans is set because a small file with thousands of progressive scans would take
    // minutes.
    constexpr int kFlags = TJFLAG_ACCURATEDCT | TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS;
    if (tjDecompress2(handle_.get(), bytes(file), static_cast<unsigned long>(file.size()),
                      picture.rgb.data(), static_cast<int>(known->width), 0,
                      static_cast<int>(known->height), TJPF_RGB, kFlags) != 0) {
      return damaged();
    }
    return picture;
  }

 private:
  static const unsigned char* bytes(std::string_view file) {
    return reinterpret_cast<const unsigned char*>(file.data());
  }

  std::unique_ptr<void, int (*)(void*)> handle_;
};

Result<TextureSize> jpeg_size(std::string_view file) { return JpegReader().size(file); }
Result<TexturePicture> decode_jpeg(std::string_view file) { return JpegReader().decode(file); }
#else
Result<TextureSize> jpeg_size(std::string_view) { return left_out("JPEG"); }
Result<TexturePicture> decode_jpeg(std::string_view) { return left_out("JPEG"); }
#endif

}  // namespace

Result<TextureSize> texture_size(std::string_view file) {
  if (file.size() > kMostTextureBytes) {
    return fail(ErrorCode::kInvalid, "must be a file of at most 8 MiB");
  }
  if (file.starts_with(kPngHead)) return png_size(file);
  if (file.starts_with(kJpegHead)) return jpeg_size(file);
  if (scene::is_radiance(file)) {
    return scene::environment_size(file).map([](const auto& size) {
      return TextureSize{size[0], size[1]};
    });
  }
  return no_picture();
}

Result<TexturePicture> decode_texture(std::string_view file) {
  const auto size = texture_size(file);
  DIAPHANE_TRY(size);
  if (scene::is_radiance(file)) {
    auto read = scene::read_environment(file);
    DIAPHANE_TRY(read);
    return TexturePicture{*size, {}, std::move(read->pixels)};
  }
  return file.starts_with(kPngHead) ? decode_png(file) : decode_jpeg(file);
}

const std::array<float, 256>& linear_of_srgb() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> linear{};
    for (std::size_t i = 0; i < linear.size(); ++i) {
      const double v = static_cast<double>(i) / 255;
      linear[i] = static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
    }
    return linear;
  }();
  return table;
}

}  // namespace diaphane::render
