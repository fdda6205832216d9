#include "renderd/encode/mpeg1_encoder.h"

#include <algorithm>
#include <cmath>

#include "common/try.h"
#include "renderd/encode/ffmpeg.h"

namespace diaphane::render {
namespace {

constexpr int kFinest = 2;
constexpr int kCoarsest = 31;
constexpr int kMovingQuantiser = 5;
constexpr int kSettledQuantiser = 2;
constexpr std::uint32_t kLargestSide = 4094;  // twelve bits, rounded down to even

/// Scales a size down to the limits of MPEG-1, keeping its aspect ratio.
Canvas fitted(Canvas size) {
  const double scale = double(kLargestSide) / std::max({size.width, size.height, kLargestSide});
  const auto side = [scale](std::uint32_t of) {
    return std::max<std::uint32_t>(1, static_cast<std::uint32_t>(std::lround(of * scale)));
  };
  return {side(size.width), side(size.height)};
}

class Mpeg1Encoder final : public Encoder {
 public:
  Mpeg1Encoder(const AVCodec* codec, ffmpeg::Packet packet)
      : codec_(codec), packet_(std::move(packet)) {}

  Result<CodedFrame> encode(const PictureRgb8& picture, const EncodeRequest& request) override {
    DIAPHANE_TRY(check_picture(picture));
    const Canvas shown = fitted(picture.size);
    const Canvas size = ffmpeg::even(shown);
    const bool open = !context_ || size != size_;
    if (open) {
      DIAPHANE_TRY(start(size));
    }
    auto converted = converter_.convert(picture, size);
    DIAPHANE_TRY(converted);
    const int best = request.quality == Quality::kSettled ? kSettledQuantiser : kMovingQuantiser;
    // The size in bytes is roughly proportional to the pixels, so a value from another size is a
    // usable start.
    quantiser_ = next_quantiser(quantiser_, bytes_, request.most_bytes, best);
    AVFrame& frame = **converted;
    frame.pts = next_++;
    frame.quality = quantiser_ * FF_QP2LAMBDA;
    frame.pict_type = open || request.key ? AV_PICTURE_TYPE_I : AV_PICTURE_TYPE_NONE;
    CodedFrame coded;
    coded.codec = v1::MPEG1;
    coded.size = shown;
    auto data = ffmpeg::code(*context_, frame, *packet_, coded.key);
    if (!data) {
      context_.reset();
      return tl::unexpected(data.error());
    }
    bytes_ = data->size();
    coded.data = std::move(*data);
    return coded;
  }

 private:
  Result<void> start(Canvas size) {
    context_.reset(avcodec_alloc_context3(codec_));
    if (!context_)
      return fail(ErrorCode::kOutOfMemory, "There is not enough memory for the MPEG-1 encoder.");
    AVCodecContext& context = *context_;
    context.width = static_cast<int>(size.width);
    context.height = static_cast<int>(size.height);
    context.pix_fmt = AV_PIX_FMT_YUV420P;
    context.time_base = {1, 30};
    context.gop_size = 600;  // maximum of FFmpeg
    context.max_b_frames = 0;
    context.thread_count = 1;
    // Without this flag, FFmpeg delays each frame in case B frames follow.
    context.strict_std_compliance = FF_COMPLIANCE_UNOFFICIAL;
    context.flags |= AV_CODEC_FLAG_QSCALE | AV_CODEC_FLAG_LOW_DELAY;
    // Disables key frames at scene changes.
    av_opt_set_int(context.priv_data, "sc_threshold", 1000000000, 0);
    context.global_quality = kMovingQuantiser * FF_QP2LAMBDA;
    context.qmin = kFinest;
    context.qmax = kCoarsest;
    const int opened = avcodec_open2(&context, codec_, nullptr);
    if (opened < 0) {
      context_.reset();
      return fail(ErrorCode::kUnsupported,
                  "The MPEG-1 encoder could not be opened: " + ffmpeg::error_text(opened));
    }
    size_ = size;
    return {};
  }

  const AVCodec* const codec_;
  ffmpeg::YuvConverter converter_{ffmpeg::Matrix::kBt601};
  ffmpeg::Packet packet_;
  ffmpeg::Context context_;
  Canvas size_;
  int quantiser_ = kMovingQuantiser;
  std::size_t bytes_ = 0;
  std::int64_t next_ = 0;
};

}  // namespace

int next_quantiser(int before, std::size_t bytes, std::size_t most, int best) {
  if (most == 0 || bytes == 0) return best;
  // The size of a frame is roughly inversely proportional to the quantiser. A margin of a quarter
  // allows for more motion.
  const double target = 1.25 * before * static_cast<double>(bytes) / static_cast<double>(most);
  // The quantiser rises at once and falls in small steps, because near the noise level a step
  // changes the size much.
  const int finer = before - std::max(1, before / 12);
  return std::clamp(std::max(static_cast<int>(std::ceil(target)), finer), best, kCoarsest);
}

Result<std::unique_ptr<Encoder>> make_mpeg1_encoder() {
  av_log_set_level(AV_LOG_QUIET);  // errors are returned as values instead
  const AVCodec* codec = avcodec_find_encoder(AV_CODEC_ID_MPEG1VIDEO);
  if (!codec) return fail(ErrorCode::kUnsupported, "This FFmpeg has no MPEG-1 encoder.");
  ffmpeg::Packet packet(av_packet_alloc());
  if (!packet)
    return fail(ErrorCode::kOutOfMemory, "There is not enough memory for the MPEG-1 encoder.");
  return std::make_unique<Mpeg1Encoder>(codec, std::move(packet));
}

}  // namespace diaphane::render
