#include "renderd/encode/encoder.h"

#include "renderd/encode/h264_encoder.h"
#include "renderd/encode/jpeg_encoder.h"
#include "renderd/encode/mpeg1_encoder.h"

namespace diaphane::render {

Result<void> check_picture(const PictureRgb8& picture) {
  const Canvas size = picture.size;
  if (size.width == 0 || size.height == 0 ||
      picture.pixels.size() != std::size_t{3} * size.width * size.height) {
    return fail(ErrorCode::kInternal, "The size of an image does not match its pixels.");
  }
  return {};
}

bool can_encode(v1::Codec codec) {
  switch (codec) {
    case v1::JPEG:
    case v1::MPEG1:
      return true;
    case v1::H264:
      return choose_h264(h264_probe()).has_value();
    default:
      return false;
  }
}

Result<std::unique_ptr<Encoder>> make_encoder(v1::Codec codec) {
  if (codec == v1::JPEG) return make_jpeg_encoder();
  if (codec == v1::MPEG1) return make_mpeg1_encoder();
  if (codec == v1::H264) {
    if (const auto device = choose_h264(h264_probe())) return make_h264_encoder(*device);
  }
  return fail(ErrorCode::kUnsupported, "The server does not support this image format.");
}

}  // namespace diaphane::render
