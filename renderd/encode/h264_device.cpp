#include "renderd/encode/h264_device.h"

#include "common/log.h"
#include "common/try.h"
#include "renderd/encode/h264_encoder.h"

namespace diaphane::render {
namespace {

// Returns a grey picture in a size that every encoder accepts (the minimum of NVENC is 145 x 49).
PictureRgb8 test_frame() {
  PictureRgb8 picture;
  picture.size = {256, 256};
  picture.pixels.assign(std::size_t{3} * 256 * 256, 128);
  return picture;
}

Result<void> try_device(H264Device device) {
  auto encoder = make_h264_encoder(device);
  DIAPHANE_TRY(encoder);
  const auto coded = (*encoder)->encode(test_frame(), {Quality::kMoving, true, 0});
  DIAPHANE_TRY(coded);
  if (!coded->key || coded->decoder.empty()) {
    return fail(ErrorCode::kUnsupported, "The first frame is not a key frame with headers.");
  }
  return {};
}

H264Probe probe() {
  H264Probe found;
  found.x264 = try_device(H264Device::kX264).has_value();
  const auto nvenc = try_device(H264Device::kNvenc);
  found.nvenc = nvenc.has_value();
  if (!nvenc) found.nvenc_why_not = nvenc.error().message;
  const auto chosen = choose_h264(found);
  log::info("h264", {{"encoder", !chosen                         ? "none"
                                 : *chosen == H264Device::kNvenc ? "nvenc"
                                                                 : "x264"},
                     {"nvenc_why_not", found.nvenc_why_not}});
  return found;
}

}  // namespace

std::optional<H264Device> choose_h264(const H264Probe& probe) {
  if (probe.nvenc) return H264Device::kNvenc;
  if (probe.x264) return H264Device::kX264;
  return std::nullopt;
}

const H264Probe& h264_probe() {
  static const H264Probe found = probe();
  return found;
}

}  // namespace diaphane::render
