#include <array>

#include "scene/panorama_readers.h"

#ifdef DIAPHANE_HAVE_EXR
#include <tinyexr.h>
#endif

namespace diaphane::scene {

#ifdef DIAPHANE_HAVE_EXR

namespace {

struct Exr {
  EXRHeader header{};
  EXRImage image{};
  bool decoded = false;

  Exr() {
    InitEXRHeader(&header);
    InitEXRImage(&image);
  }
  Exr(const Exr&) = delete;
  Exr& operator=(const Exr&) = delete;
  ~Exr() {
    if (decoded) FreeEXRImage(&image);
    FreeEXRHeader(&header);
  }
};

/// Returns whether tinyexr succeeded, and frees its message.
bool succeeded(int result, const char* message) {
  if (message != nullptr) FreeEXRErrorMessage(message);
  return result == TINYEXR_SUCCESS;
}

/// Returns the indices of the planes of R, G and B, or -1 for a channel that is missing.
std::array<int, 3> planes_of(const EXRHeader& header) {
  std::array<int, 3> planes{-1, -1, -1};
  for (int c = 0; c < header.num_channels; ++c) {
    const std::string_view name = header.channels[c].name;
    for (std::size_t i = 0; i < planes.size(); ++i) {
      if (name == std::string_view("RGB").substr(i, 1)) planes[i] = c;
    }
  }
  return planes;
}

bool is_supported(const EXRHeader& header) {
  const auto planes = planes_of(header);
  bool supported = header.tiled == 0 && header.num_channels <= kMostPanoramaChannels &&
                   header.compression_type <= TINYEXR_COMPRESSIONTYPE_PIZ && planes[0] >= 0 &&
                   planes[1] >= 0 && planes[2] >= 0;
  for (int c = 0; supported && c < header.num_channels; ++c) {
    supported = header.pixel_types[c] != TINYEXR_PIXELTYPE_UINT &&
                header.channels[c].x_sampling == 1 && header.channels[c].y_sampling == 1;
  }
  return supported;
}

}  // namespace

tl::expected<EnvironmentPicture, PanoramaFault> read_exr(std::string_view file) {
  const auto fails = [](PanoramaFault fault) { return tl::unexpected(fault); };
  const auto* const bytes = reinterpret_cast<const unsigned char*>(file.data());
  EXRVersion version{};
  if (ParseEXRVersionFromMemory(&version, bytes, file.size()) != TINYEXR_SUCCESS) {
    return fails(PanoramaFault::kDamaged);
  }
  if (version.tiled != 0 || version.multipart != 0 || version.non_image != 0) {
    return fails(PanoramaFault::kVariant);
  }
  Exr exr;
  const char* message = nullptr;
  int result = ParseEXRHeaderFromMemory(&exr.header, &version, bytes, file.size(), &message);
  if (!succeeded(result, message)) {
    return fails(result == TINYEXR_ERROR_UNSUPPORTED_FORMAT ? PanoramaFault::kVariant
                                                            : PanoramaFault::kDamaged);
  }
  if (!is_supported(exr.header)) return fails(PanoramaFault::kVariant);
  const EXRBox2i& window = exr.header.data_window;
  const std::int64_t width = std::int64_t{window.max_x} - window.min_x + 1;
  const std::int64_t height = std::int64_t{window.max_y} - window.min_y + 1;
  if (width < 1 || height < 1) return fails(PanoramaFault::kDamaged);
  if (const auto fault =
          fault_of_size(static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height))) {
    return fails(*fault);
  }
  for (int c = 0; c < exr.header.num_channels; ++c) {
    exr.header.requested_pixel_types[c] = TINYEXR_PIXELTYPE_FLOAT;
  }
  message = nullptr;
  result = LoadEXRImageFromMemory(&exr.image, &exr.header, bytes, file.size(), &message);
  exr.decoded = succeeded(result, message);
  const bool whole = exr.decoded && exr.image.images != nullptr && exr.image.width == width &&
                     exr.image.height == height;
  if (!whole) return fails(PanoramaFault::kDamaged);
  PanoramaReduction reduction(static_cast<std::uint32_t>(width),
                              static_cast<std::uint32_t>(height));
  const auto planes = planes_of(exr.header);
  const auto plane = [&](std::size_t i) {
    return reinterpret_cast<const float*>(exr.image.images[planes[i]]);
  };
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      const std::size_t at = x + std::size_t{y} * static_cast<std::size_t>(width);
      reduction.add(x, y, plane(0)[at], plane(1)[at], plane(2)[at]);
    }
  }
  return reduction.finish();
}

#else

tl::expected<EnvironmentPicture, PanoramaFault> read_exr(std::string_view) {
  return tl::unexpected(PanoramaFault::kFormat);
}

#endif

}  // namespace diaphane::scene
