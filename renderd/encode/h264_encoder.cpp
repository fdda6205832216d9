#include "renderd/encode/h264_encoder.h"

#include <algorithm>
#include <cmath>

#include "common/try.h"
#include "renderd/encode/ffmpeg.h"
#include "renderd/encode/h264_stream.h"

namespace diaphane::render {
namespace {

// Frames have no fixed duration. This rate converts the limit in bytes per frame to the bit rate
// that FFmpeg expects.
constexpr int kFramesPerSecond = 30;
constexpr std::int64_t kUnbounded = std::int64_t{1} << 22;  // bytes, more than any settled 4K frame
constexpr std::int64_t kFewestBytes = 1024;                 // smaller frames consist of headers
constexpr double kMovingRateFactor = 25;
constexpr double kSettledRateFactor = 17;

std::int64_t bound(const EncodeRequest& request) {
  if (request.most_bytes == 0) return kUnbounded;
  return std::clamp<std::int64_t>(request.most_bytes, kFewestBytes, kUnbounded);
}

class H264Encoder final : public Encoder {
 public:
  H264Encoder(H264Device device, const AVCodec* codec, ffmpeg::Packet packet)
      : device_(device), codec_(codec), packet_(std::move(packet)) {}

  Result<CodedFrame> encode(const PictureRgb8& picture, const EncodeRequest& request) override {
    DIAPHANE_TRY(check_picture(picture));
    const Canvas size = ffmpeg::even(picture.size);
    const bool open = !context_ || size != size_;
    if (open) {
      DIAPHANE_TRY(start(size, request));
    } else if (const auto done = set_bound(request); !done) {
      return tl::unexpected(done.error());
    }
    auto converted = converter_.convert(picture);
    DIAPHANE_TRY(converted);
    AVFrame& frame = **converted;
    frame.pts = next_++;
    frame.pict_type = open || request.key ? AV_PICTURE_TYPE_I : AV_PICTURE_TYPE_NONE;
    CodedFrame coded;
    coded.codec = v1::H264;
    coded.size = picture.size;
    auto data = ffmpeg::code(*context_, frame, *packet_, coded.key);
    if (!data) {
      context_.reset();  // its state is unknown, so the next frame starts a new encoder
      return tl::unexpected(data.error());
    }
    coded.data = std::move(*data);
    if (coded.key) {
      coded.decoder = h264_decoder_name(coded.data).value_or("");
      if (coded.decoder.empty()) {
        return fail(ErrorCode::kInternal, "A key frame lacks a sequence parameter set.");
      }
    }
    return coded;
  }

 private:
  Result<void> start(Canvas size, const EncodeRequest& request) {
    context_.reset(avcodec_alloc_context3(codec_));
    if (!context_)
      return fail(ErrorCode::kOutOfMemory, "There is not enough memory for the H.264 encoder.");
    AVCodecContext& context = *context_;
    ffmpeg::set_bt709(context, size, kFramesPerSecond);
    context.max_b_frames = 0;
    bytes_ = bound(request);
    apply_bound();
    set_options(request);
    const int opened = avcodec_open2(&context, codec_, nullptr);
    if (opened < 0) {
      context_.reset();
      return fail(ErrorCode::kUnsupported, std::string(codec_->name) + " could not be opened: " +
                                               ffmpeg::error_text(opened));
    }
    size_ = size;
    return {};
  }

  void set_options(const EncodeRequest& request) {
    AVCodecContext& context = *context_;
    void* options = context.priv_data;
    av_opt_set(options, "profile", "high", 0);
    av_opt_set(options, "forced-idr", "1", 0);
    if (device_ == H264Device::kX264) {
      context.gop_size = 1 << 30;  // "infinite" for x264
      av_opt_set(options, "preset", "superfast", 0);
      av_opt_set(options, "tune", "zerolatency", 0);
      av_opt_set(options, "x264-params", "scenecut=0", 0);
      set_rate_factor(request.quality);
    } else {
      context.gop_size = -1;  // "infinite" for NVENC
      av_opt_set(options, "preset", "p2", 0);
      av_opt_set(options, "tune", "ull", 0);
      av_opt_set(options, "rc", "cbr", 0);
      av_opt_set(options, "zerolatency", "1", 0);
      av_opt_set(options, "delay", "0", 0);
      av_opt_set(options, "no-scenecut", "1", 0);
    }
  }

  void set_rate_factor(Quality quality) {
    av_opt_set_double(context_->priv_data, "crf",
                      quality == Quality::kSettled ? kSettledRateFactor : kMovingRateFactor, 0);
  }

  void apply_bound() {
    const std::int64_t bits = 8 * bytes_;
    context_->rc_max_rate = bits * kFramesPerSecond;
    context_->rc_buffer_size = static_cast<int>(bits);
    context_->rc_initial_buffer_occupancy = context_->rc_buffer_size;
    if (device_ == H264Device::kNvenc) context_->bit_rate = context_->rc_max_rate;
  }

  // Sets the rate limit of the next frame. FFmpeg applies changes of these fields at each frame.
  Result<void> set_bound(const EncodeRequest& request) {
    const std::int64_t target = bound(request);
    if (device_ == H264Device::kX264) {
      set_rate_factor(request.quality);
    } else if (std::abs(target - bytes_) * 4 < bytes_) {
      return {};  // NVENC needs a key frame for each new rate
    }
    if (target != bytes_) {
      bytes_ = target;
      apply_bound();
    }
    return {};
  }

  const H264Device device_;
  const AVCodec* const codec_;
  ffmpeg::YuvConverter converter_{ffmpeg::Matrix::kBt709};
  ffmpeg::Packet packet_;
  ffmpeg::Context context_;
  Canvas size_;
  std::int64_t bytes_ = 0;
  std::int64_t next_ = 0;
};

}  // namespace

Result<std::unique_ptr<Encoder>> make_h264_encoder(H264Device device) {
  av_log_set_level(AV_LOG_QUIET);  // errors are returned as values instead
  const char* name = device == H264Device::kNvenc ? "h264_nvenc" : "libx264";
  const AVCodec* codec = avcodec_find_encoder_by_name(name);
  if (!codec) {
    return fail(ErrorCode::kUnsupported, std::string("This FFmpeg has no ") + name + ".");
  }
  ffmpeg::Packet packet(av_packet_alloc());
  if (!packet)
    return fail(ErrorCode::kOutOfMemory, "There is not enough memory for the H.264 encoder.");
  return std::make_unique<H264Encoder>(device, codec, std::move(packet));
}

}  // namespace diaphane::render
