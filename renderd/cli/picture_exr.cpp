#include <array>
#include <cstring>
#include <vector>

#include "renderd/cli/picture_file.h"

#ifdef DIAPHANE_HAVE_EXR
#include <tinyexr.h>
#endif

namespace diaphane::render::cli {

#ifdef DIAPHANE_HAVE_EXR

Result<std::string> encode_exr(const PictureRgbF& picture) {
  const std::size_t pixels = std::size_t{picture.size.width} * picture.size.height;
  // Readers expect the channels in alphabetical order.
  constexpr std::array<const char*, 3> kNames{"B", "G", "R"};
  std::array<std::vector<float>, 3> planes;
  std::array<unsigned char*, 3> pointers{};
  std::array<EXRChannelInfo, 3> channels{};
  std::array<int, 3> types{};
  for (std::size_t c = 0; c < 3; ++c) {
    planes[c].resize(pixels);
    for (std::size_t i = 0; i < pixels; ++i) planes[c][i] = picture.pixels[3 * i + 2 - c];
    pointers[c] = reinterpret_cast<unsigned char*>(planes[c].data());
    std::strncpy(channels[c].name, kNames[c], sizeof channels[c].name - 1);
    types[c] = TINYEXR_PIXELTYPE_FLOAT;
  }
  EXRHeader header;
  InitEXRHeader(&header);
  header.num_channels = 3;
  header.channels = channels.data();
  header.pixel_types = types.data();
  header.requested_pixel_types = types.data();
  header.compression_type = TINYEXR_COMPRESSIONTYPE_ZIP;
  EXRImage image;
  InitEXRImage(&image);
  image.num_channels = 3;
  image.images = pointers.data();
  image.width = static_cast<int>(picture.size.width);
  image.height = static_cast<int>(picture.size.height);

  unsigned char* memory = nullptr;
  const char* why = nullptr;
  const std::size_t size = SaveEXRImageToMemory(&image, &header, &memory, &why);
  if (size == 0) {
    std::string message = std::string("tinyexr: ") + (why ? why : "no reason given");
    if (why) FreeEXRErrorMessage(why);
    return fail(ErrorCode::kInternal, std::move(message));
  }
  std::string bytes(reinterpret_cast<const char*>(memory), size);
  std::free(memory);
  return bytes;
}

#else

Result<std::string> encode_exr(const PictureRgbF&) {
  return fail(ErrorCode::kUnsupported, "this program was built without tinyexr");
}

#endif

}  // namespace diaphane::render::cli
