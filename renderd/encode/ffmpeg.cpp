#include "renderd/encode/ffmpeg.h"

#include <algorithm>
#include <cstring>

#include "common/try.h"

namespace diaphane::render::ffmpeg {

std::string error_text(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, text, sizeof text);
  return text;
}

Canvas even(Canvas size) { return {(size.width + 1) / 2 * 2, (size.height + 1) / 2 * 2}; }

Result<void> YuvConverter::prepare(Canvas from, Canvas to) {
  if (frame_ && from == from_ && to == to_) {
    // The encoder may still hold a reference to the planes.
    if (av_frame_make_writable(frame_.get()) < 0) {
      return fail(ErrorCode::kOutOfMemory, "There is not enough memory to encode an image.");
    }
    return {};
  }
  const int width = static_cast<int>(to.width);
  const int height = static_cast<int>(to.height);
  Frame frame(av_frame_alloc());
  scaler_.reset(sws_getContext(static_cast<int>(from.width), static_cast<int>(from.height),
                               AV_PIX_FMT_RGB24, width, height, AV_PIX_FMT_YUV420P,
                               SWS_AREA | SWS_ACCURATE_RND, nullptr, nullptr, nullptr));
  if (!frame || !scaler_)
    return fail(ErrorCode::kOutOfMemory, "There is not enough memory to encode an image.");
  const bool bt709 = matrix_ == Matrix::kBt709;
  const int* matrix = sws_getCoefficients(bt709 ? SWS_CS_ITU709 : SWS_CS_ITU601);
  sws_setColorspaceDetails(scaler_.get(), matrix, 1, matrix, 0, 0, 1 << 16, 1 << 16);
  frame->format = AV_PIX_FMT_YUV420P;
  frame->width = width;
  frame->height = height;
  frame->color_range = AVCOL_RANGE_MPEG;
  frame->colorspace = bt709 ? AVCOL_SPC_BT709 : AVCOL_SPC_SMPTE170M;
  if (av_frame_get_buffer(frame.get(), 0) < 0) {
    return fail(ErrorCode::kOutOfMemory, "There is not enough memory to encode an image.");
  }
  frame_ = std::move(frame);
  from_ = from;
  to_ = to;
  return {};
}

Result<AVFrame*> YuvConverter::convert(const PictureRgb8& picture, Canvas to) {
  const Canvas from = picture.size;
  const Canvas padded = even(from);
  DIAPHANE_TRY(prepare(padded, to));
  const std::uint8_t* pixels = picture.pixels.data();
  const std::size_t row = std::size_t{3} * from.width;
  const std::size_t stride = std::size_t{3} * padded.width;
  if (padded != from) {
    padded_.resize(stride * padded.height);
    for (std::size_t y = 0; y < padded.height; ++y) {
      std::uint8_t* out = padded_.data() + stride * y;
      std::memcpy(out, pixels + row * std::min<std::size_t>(y, from.height - 1), row);
      if (stride > row) std::memcpy(out + row, out + row - 3, 3);
    }
    pixels = padded_.data();
  }
  const std::uint8_t* const planes[] = {pixels};
  const int strides[] = {static_cast<int>(stride)};
  sws_scale(scaler_.get(), planes, strides, 0, static_cast<int>(padded.height), frame_->data,
            frame_->linesize);
  return frame_.get();
}

void set_bt709(AVCodecContext& coder, Canvas size, int frames_per_second) {
  coder.width = static_cast<int>(size.width);
  coder.height = static_cast<int>(size.height);
  coder.pix_fmt = AV_PIX_FMT_YUV420P;
  coder.time_base = {1, frames_per_second};
  coder.framerate = {frames_per_second, 1};
  coder.color_range = AVCOL_RANGE_MPEG;
  coder.colorspace = AVCOL_SPC_BT709;
  coder.color_primaries = AVCOL_PRI_BT709;
  coder.color_trc = AVCOL_TRC_BT709;
  coder.thread_count = 1;
}

Result<std::string> code(AVCodecContext& context, const AVFrame& frame, AVPacket& packet,
                         bool& key) {
  int result = avcodec_send_frame(&context, &frame);
  if (result >= 0) result = avcodec_receive_packet(&context, &packet);
  if (result < 0) {
    return fail(ErrorCode::kInternal, "An image could not be encoded: " + error_text(result) + ".");
  }
  std::string data(reinterpret_cast<const char*>(packet.data),
                   static_cast<std::size_t>(packet.size));
  key = (packet.flags & AV_PKT_FLAG_KEY) != 0;
  av_packet_unref(&packet);
  return data;
}

}  // namespace diaphane::render::ffmpeg
