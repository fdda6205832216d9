#pragma once

// FFmpeg helpers for the video encoders. To be included only by .cpp files of this folder.

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

/// Returns FFmpeg's text for one of its error numbers.
std::string error_text(int error);

/// Rounds each side up to an even number, because chroma is subsampled by two.
Canvas even(Canvas size);

enum class Matrix { kBt709, kBt601 };

/// Converts RGB to planar YUV 4:2:0 in limited range (16 to 235) with chroma averaged over 2 x 2.
/// Pads a picture with an odd side by repeating its last column or row, then scales it if a smaller
/// one is requested.
class YuvConverter {
 public:
  explicit YuvConverter(Matrix matrix) : matrix_(matrix) {}
  /// Converts to a frame of `even(picture.size)`. The converter owns the frame, which is valid
  /// until the next call.
  Result<AVFrame*> convert(const PictureRgb8& picture) {
    return convert(picture, even(picture.size));
  }
  /// Converts to size `to`, whose sides are even.
  Result<AVFrame*> convert(const PictureRgb8& picture, Canvas to);

 private:
  Result<void> prepare(Canvas from, Canvas to);

  const Matrix matrix_;
  Canvas from_, to_;
  Frame frame_;
  std::unique_ptr<SwsContext, FreeScaler> scaler_;
  std::vector<std::uint8_t> padded_;
};

/// Configures a coder, before it is opened, for the output of YuvConverter with kBt709, so that
/// players show the right colours. Limits it to one thread, because pictures of several sessions
/// are encoded in parallel.
void set_bt709(AVCodecContext& coder, Canvas size, int frames_per_second);

/// Encodes one frame into exactly one packet. An encoder that holds a frame back is an error,
/// because a viewer would wait for it.
Result<std::string> code(AVCodecContext& context, const AVFrame& frame, AVPacket& packet,
                         bool& key);

}  // namespace diaphane::render::ffmpeg
