// The output of the video encoders is decoded with libavcodec and compared with the input.

extern "C" {
#include <libavcodec/avcodec.h>
}

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "renderd/encode/h264_encoder.h"
#include "renderd/encode/h264_stream.h"
#include "renderd/encode/mpeg1_encoder.h"
#include "tests/support/renderd/test_pictures.h"

namespace diaphane::render {
namespace {

/// A decoder like a viewer's: it gets one frame and must show it before the next one.
class Viewer {
 public:
  explicit Viewer(AVCodecID codec) : context_(avcodec_alloc_context3(nullptr)) {
    const AVCodec* decoder = avcodec_find_decoder(codec);
    avcodec_free_context(&context_);
    context_ = avcodec_alloc_context3(decoder);
    context_->thread_count = 1;
    context_->flags |= AV_CODEC_FLAG_LOW_DELAY;
    EXPECT_EQ(avcodec_open2(context_, decoder, nullptr), 0);
  }
  ~Viewer() {
    av_frame_free(&frame_);
    av_packet_free(&packet_);
    avcodec_free_context(&context_);
  }
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  /// Returns null if nothing could be shown.
  const AVFrame* show(const std::string& data) {
    EXPECT_EQ(av_new_packet(packet_, static_cast<int>(data.size())), 0);
    std::copy(data.begin(), data.end(), packet_->data);
    const int sent = avcodec_send_packet(context_, packet_);
    av_packet_unref(packet_);
    if (sent < 0 || avcodec_receive_frame(context_, frame_) < 0) return nullptr;
    return frame_;
  }

 private:
  AVCodecContext* context_;
  AVFrame* frame_ = av_frame_alloc();
  AVPacket* packet_ = av_packet_alloc();
};

struct Weights {
  double red, blue;  // of luma (ITU-R BT.709 and BT.601)
};
constexpr Weights kBt709{0.2126, 0.0722};
constexpr Weights kBt601{0.299, 0.114};

/// Limited range YUV to RGB by the standards' own formulas, cut to `size`.
PictureRgb8 to_rgb(const AVFrame& frame, Canvas size, Weights weights) {
  PictureRgb8 picture;
  picture.size = size;
  const auto byte = [](double value) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
  };
  for (std::uint32_t y = 0; y < size.height; ++y) {
    for (std::uint32_t x = 0; x < size.width; ++x) {
      const auto at = [&](int plane, std::uint32_t px, std::uint32_t py) {
        return double(
            frame.data[plane][py * static_cast<std::uint32_t>(frame.linesize[plane]) + px]);
      };
      const double luma = (at(0, x, y) - 16) * 255 / 219;
      const double cb = (at(1, x / 2, y / 2) - 128) * 255 / 224;
      const double cr = (at(2, x / 2, y / 2) - 128) * 255 / 224;
      const double red = luma + 2 * (1 - weights.red) * cr;
      const double blue = luma + 2 * (1 - weights.blue) * cb;
      const double green =
          (luma - weights.red * red - weights.blue * blue) / (1 - weights.red - weights.blue);
      picture.pixels.insert(picture.pixels.end(), {byte(red), byte(green), byte(blue)});
    }
  }
  return picture;
}

PictureRgb8 noise(Canvas size, unsigned seed) {
  std::mt19937 random(seed);
  PictureRgb8 picture = smooth_picture(size.width, size.height);
  for (std::uint8_t& value : picture.pixels) {
    value = static_cast<std::uint8_t>(std::clamp(int(value) + int(random() % 81) - 40, 0, 255));
  }
  return picture;
}

std::unique_ptr<Encoder> h264() {
  auto encoder = make_h264_encoder(H264Device::kX264);
  EXPECT_TRUE(encoder) << (encoder ? "" : encoder.error().message);
  return std::move(*encoder);
}

struct VideoCase {
  const char* name;
  v1::Codec codec;
  AVCodecID decoder;
  Weights weights;
};

class Video : public testing::TestWithParam<VideoCase> {
 protected:
  std::unique_ptr<Encoder> encoder() {
    auto made = make_encoder(GetParam().codec);
    EXPECT_TRUE(made);
    return std::move(*made);
  }
};

// Rounding to 8 bits and the finest quantiser leave luma and chroma of a plain picture at most one
// step off. Blue is luma + 2 (1 - Kb) Cb: 255/219 + 255/224 * 1.8556 = 3.3 steps of 8 bits, half of
// one more for rounding; red and green have smaller sums. A wrong matrix or range is 10 and more.
TEST_P(Video, RoundTripsColours) {
  struct Colour {
    std::uint8_t red, green, blue;
  };
  for (const Colour& colour : {Colour{255, 0, 0}, Colour{224, 172, 140}, Colour{0, 0, 255},
                               Colour{255, 255, 255}, Colour{0, 0, 0}, Colour{90, 140, 60}}) {
    const PictureRgb8 picture = plain_picture({64, 64}, colour.red, colour.green, colour.blue);
    const auto coded = encoder()->encode(picture, {Quality::kSettled, true, 0});
    ASSERT_TRUE(coded);
    Viewer viewer(GetParam().decoder);
    const AVFrame* frame = viewer.show(coded->data);
    ASSERT_TRUE(frame);
    const PictureRgb8 shown = to_rgb(*frame, picture.size, GetParam().weights);
    for (std::size_t i = 0; i < shown.pixels.size(); ++i) {
      ASSERT_NEAR(shown.pixels[i], picture.pixels[i], 4) << int(colour.red) << " channel " << i % 3;
    }
  }
}

TEST_P(Video, DecodesEachFrameWithoutDelay) {
  const auto coder = encoder();
  Viewer viewer(GetParam().decoder);
  for (int i = 0; i < 20; ++i) {
    const PictureRgb8 picture = smooth_picture(320, 200, 0.2 * i);
    const auto coded = coder->encode(picture, {Quality::kSettled, false, 0});
    ASSERT_TRUE(coded);
    EXPECT_EQ(coded->key, i == 0) << "key frames are sent on request only";
    const AVFrame* frame = viewer.show(coded->data);
    ASSERT_TRUE(frame) << i;
    EXPECT_LT(rms(picture, to_rgb(*frame, picture.size, GetParam().weights)), 4.0) << i;
  }
}

TEST_P(Video, SupportsAnySizeAndStartsNewSizesWithAKeyFrame) {
  const auto coder = encoder();
  Viewer viewer(GetParam().decoder);
  for (const Canvas size :
       {Canvas{64, 48}, Canvas{65, 47}, Canvas{17, 33}, Canvas{16, 16}, Canvas{641, 359}}) {
    for (const bool first : {true, false}) {
      const PictureRgb8 picture = smooth_picture(size.width, size.height);
      const auto coded = coder->encode(picture, {Quality::kSettled, false, 0});
      ASSERT_TRUE(coded) << coded.error().message;
      EXPECT_EQ(coded->key, first);
      const AVFrame* frame = viewer.show(coded->data);
      ASSERT_TRUE(frame);
      EXPECT_EQ(frame->width, int(size.width + size.width % 2));
      EXPECT_EQ(frame->height, int(size.height + size.height % 2));
      EXPECT_LT(rms(picture, to_rgb(*frame, size, GetParam().weights)), 8.0);
    }
  }
}

TEST_P(Video, NewViewerDecodesARequestedKeyFrame) {
  const auto coder = encoder();
  for (int i = 0; i < 12; ++i) {
    const bool ask = i == 5 || i == 9;
    const PictureRgb8 picture = smooth_picture(320, 200, 0.2 * i);
    const auto coded = coder->encode(picture, {Quality::kSettled, ask, 0});
    ASSERT_TRUE(coded);
    EXPECT_EQ(coded->key, ask || i == 0);
    Viewer newcomer(GetParam().decoder);
    const AVFrame* frame = newcomer.show(coded->data);
    if (!coded->key) continue;
    ASSERT_TRUE(frame);
    EXPECT_LT(rms(picture, to_rgb(*frame, picture.size, GetParam().weights)), 4.0);
  }
}

// The limit is a buffer of one frame: the size of a noisy picture stays within a half of it, and
// follows it up and down without a key frame.
TEST_P(Video, AppliesNewSizeLimitWithoutAKeyFrame) {
  const auto coder = encoder();
  unsigned seed = 0;
  ASSERT_TRUE(coder->encode(noise({640, 360}, seed), {Quality::kMoving, true, 40000}));
  for (const std::uint32_t most : {40000U, 12000U, 6000U, 40000U}) {
    std::size_t bytes = 0;
    for (int i = 0; i < 12; ++i) {
      const auto coded = coder->encode(noise({640, 360}, ++seed), {Quality::kMoving, false, most});
      ASSERT_TRUE(coded);
      EXPECT_FALSE(coded->key);
      if (i >= 4) bytes = std::max(bytes, coded->data.size());  // a few frames to adapt
    }
    EXPECT_LT(bytes, most + most / 2) << most;
    EXPECT_GT(bytes, most / 4) << most;
  }
}

TEST_P(Video, RefusesImageWithWrongSize) {
  PictureRgb8 picture = smooth_picture(32, 32);
  picture.size.height = 33;
  EXPECT_FALSE(encoder()->encode(picture, {}).has_value());
  EXPECT_FALSE(encoder()->encode(PictureRgb8{}, {}).has_value());
}

INSTANTIATE_TEST_SUITE_P(Codecs, Video,
                         testing::Values(VideoCase{"H264", v1::H264, AV_CODEC_ID_H264, kBt709},
                                         VideoCase{"Mpeg1", v1::MPEG1, AV_CODEC_ID_MPEG1VIDEO,
                                                   kBt601}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(H264, SignalsItsColourSpaceAndDecoder) {
  const auto coded = h264()->encode(smooth_picture(128, 128), {Quality::kMoving, true, 0});
  ASSERT_TRUE(coded);
  EXPECT_EQ(coded->decoder.rfind("avc1.64", 0), 0U) << coded->decoder;  // High
  EXPECT_EQ(coded->decoder.size(), 11U);
  Viewer viewer(AV_CODEC_ID_H264);
  const AVFrame* frame = viewer.show(coded->data);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->colorspace, AVCOL_SPC_BT709);
  EXPECT_EQ(frame->color_primaries, AVCOL_PRI_BT709);
  EXPECT_EQ(frame->color_trc, AVCOL_TRC_BT709);
  EXPECT_EQ(frame->color_range, AVCOL_RANGE_MPEG);
}

TEST(H264, EveryKeyFrameCarriesItsParameterSets) {
  const auto coder = h264();
  for (int i = 0; i < 6; ++i) {
    const auto coded = coder->encode(smooth_picture(128, 128, i), {Quality::kMoving, i == 3, 0});
    ASSERT_TRUE(coded);
    EXPECT_EQ(h264_decoder_name(coded->data).has_value(), coded->key);
    EXPECT_EQ(coded->decoder.empty(), !coded->key);
  }
}

TEST(H264, ReadsTheDecoderNameFromTheFirstParameterSet) {
  const std::string delimiter("\0\0\0\1\x09\xf0", 6);
  const std::string sps("\0\0\0\1\x67\x42\xc0\x1f\xaa", 9);
  const std::string second("\0\0\1\x67\x64\0\x28\xaa", 8);
  EXPECT_EQ(h264_decoder_name(delimiter + sps + second), "avc1.42C01F");
  EXPECT_EQ(h264_decoder_name(second), "avc1.640028");
  EXPECT_EQ(h264_decoder_name(delimiter), std::nullopt);
  EXPECT_EQ(h264_decoder_name(sps.substr(0, 7)), std::nullopt) << "cut off";
  EXPECT_EQ(h264_decoder_name({}), std::nullopt);
}

TEST(H264Device, ChoosesNvencOnlyIfASessionOpened) {
  EXPECT_EQ(choose_h264({true, true, ""}), H264Device::kNvenc);
  EXPECT_EQ(choose_h264({false, true, ""}), H264Device::kNvenc);
  EXPECT_EQ(choose_h264({true, false, "no device"}), H264Device::kX264);
  EXPECT_EQ(choose_h264({false, false, "no device"}), std::nullopt);
}

TEST(H264Device, ProbeReportsItsFindings) {
  const H264Probe& probe = h264_probe();
  EXPECT_TRUE(probe.x264);
  EXPECT_EQ(probe.nvenc, probe.nvenc_why_not.empty());
  EXPECT_EQ(&probe, &h264_probe()) << "once a process";
  EXPECT_TRUE(can_encode(v1::H264));
  EXPECT_FALSE(can_encode(v1::CODEC_UNSPECIFIED));
}

TEST(Mpeg1, ScalesDownImagesBeyondItsSizeLimit) {
  const auto coder = make_mpeg1_encoder();
  ASSERT_TRUE(coder);
  const Canvas whole{5001, 96}, shown{4094, 79};  // a factor of 0.8186
  const auto coded =
      (*coder)->encode(smooth_picture(whole.width, whole.height), {Quality::kSettled, true, 0});
  ASSERT_TRUE(coded);
  EXPECT_EQ(coded->size, shown);
  Viewer viewer(AV_CODEC_ID_MPEG1VIDEO);
  const AVFrame* frame = viewer.show(coded->data);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->width, 4094);
  EXPECT_EQ(frame->height, 80) << "even";
  PictureRgb8 expected = smooth_picture(shown.width, shown.height);
  for (std::uint32_t i = 0; i < shown.width * shown.height; ++i) {
    const double x = (i % shown.width + 0.5) * whole.width / shown.width - 0.5;
    expected.pixels[3 * i + 2] = static_cast<std::uint8_t>(127 + 100 * std::sin(0.1 * x));
  }
  EXPECT_LT(rms(expected, to_rgb(*frame, shown, kBt601)), 4.0);
  const auto small = (*coder)->encode(smooth_picture(64, 48), {});
  ASSERT_TRUE(small);
  EXPECT_EQ(small->size, (Canvas{64, 48}));
}

TEST(NextQuantiser, FollowsTheFrameSizeWithinItsRange) {
  EXPECT_EQ(next_quantiser(10, 9000, 0, 4), 4) << "unbounded";
  EXPECT_EQ(next_quantiser(10, 0, 9000, 4), 4) << "nothing known";
  EXPECT_GT(next_quantiser(10, 9000, 9000, 4), 10) << "at the limit, some room remains for motion";
  EXPECT_EQ(next_quantiser(10, 90000, 9000, 4), 31);
  EXPECT_EQ(next_quantiser(10, 900, 9000, 4), 9) << "the quantiser decreases in small steps";
  EXPECT_EQ(next_quantiser(4, 900, 9000, 4), 4);
  for (std::size_t bytes = 1; bytes < 1U << 20; bytes *= 2) {
    EXPECT_LE(next_quantiser(8, bytes, 20000, 4), next_quantiser(8, 2 * bytes, 20000, 4));
  }
}

}  // namespace
}  // namespace diaphane::render
