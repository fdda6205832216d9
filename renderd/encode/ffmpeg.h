#pragma once

// What the two video encoders share of FFmpeg. Only .cpp files of this folder include this.

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavutil/frame.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::ffmpeg {

struct FreeContext {
  void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
};
struct FreeFrame {
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};
struct FreePacket {
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
struct FreeScaler {
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};
using Context = std::unique_ptr<AVCodecContext, FreeContext>;
using Frame = std::unique_ptr<AVFrame, FreeFrame>;
using Packet = std::unique_ptr<AVPacket, FreePacket>;

/// FFmpeg's words for one of its error numbers.
std::string error_text(int error);

/// The size with each side rounded up to the next even number: chroma is subsampled by two.
Canvas even(Canvas size);

enum class Matrix { kBt709, kBt601 };

/// RGB to planar YUV 4:2:0, limited range (16 to 235), chroma averaged over 2 x 2. A picture with
/// an odd side is padded to an even one by its last column or row, then scaled where a smaller one
/// is wanted.
class YuvConverter {
 public:
  explicit YuvConverter(Matrix matrix) : matrix_(matrix) {}
  /// Writes a frame of `even(picture.size)`; it stays the converter's, valid until the next call.
  Result<AVFrame*> convert(const PictureRgb8& picture) {
    return convert(picture, even(picture.size));
  }
  /// Of size `to`, both sides even.
  Result<AVFrame*> convert(const PictureRgb8& picture, Canvas to);

 private:
  Result<void> prepare(Canvas from, Canvas to);

  const Matrix matrix_;
  Canvas from_, to_;
  Frame frame_;
  std::unique_ptr<SwsContext, FreeScaler> scaler_;
  std::vector<std::uint8_t> padded_;
};

/// Tells a coder, before it is opened, what YuvConverter gives it by kBt709, so that players show
/// the right colours, and that it has one thread: pictures of several sessions are coded side by
/// side.
void set_bt709(AVCodecContext& coder, Canvas size, int frames_per_second);

/// Sends one frame and takes the one packet that it must yield: an encoder that holds a frame back
/// is an error, since a viewer would wait for it.
Result<std::string> code(AVCodecContext& context, const AVFrame& frame, AVPacket& packet,
                         bool& key);

}  // namespace diaphane::render::ffmpeg
