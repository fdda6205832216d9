// Videos are decoded with libavformat and libavcodec and compared with the input.

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include <gtest/gtest.h>

#include <cstdio>
#include <random>

#include "renderd/encode/video_file.h"
#include "tests/support/renderd/test_pictures.h"

namespace diaphane::render {
namespace {

VideoFormat format_of(Canvas size, std::uint32_t frames, std::uint32_t rate = 25) {
  return {size, rate, frames};
}

PictureRgb8 grey(Canvas size, int level) {
  const auto value = static_cast<std::uint8_t>(level);
  return plain_picture(size, value, value, value);
}

struct TemporaryFile {
  explicit TemporaryFile(const std::string& bytes) {
    char name[] = "/tmp/video-test-XXXXXX";
    const int fd = mkstemp(name);
    path = name;
    FILE* file = fdopen(fd, "wb");
    EXPECT_EQ(fwrite(bytes.data(), 1, bytes.size(), file), bytes.size());
    fclose(file);
  }
  ~TemporaryFile() { std::remove(path.c_str()); }
  std::string path;
};

/// What a player finds: frames in display order, by their mean luma.
struct Seen {
  int streams = 0;
  AVCodecID codec = AV_CODEC_ID_NONE;
  int pixel_format = -1;
  Canvas size;
  double seconds = 0;
  int tags = 0;
  std::vector<double> lumas;
};

Seen seen_in(const std::string& bytes) {
  const TemporaryFile file(bytes);
  Seen seen;
  AVFormatContext* container = nullptr;
  EXPECT_EQ(avformat_open_input(&container, file.path.c_str(), nullptr, nullptr), 0);
  if (!container) return seen;
  EXPECT_GE(avformat_find_stream_info(container, nullptr), 0);
  seen.streams = static_cast<int>(container->nb_streams);
  const AVStream& stream = *container->streams[0];
  seen.codec = stream.codecpar->codec_id;
  seen.pixel_format = stream.codecpar->format;
  seen.size = {static_cast<std::uint32_t>(stream.codecpar->width),
               static_cast<std::uint32_t>(stream.codecpar->height)};
  seen.seconds = static_cast<double>(stream.duration) * av_q2d(stream.time_base);
  for (const char* tag : {"title", "comment", "creation_time", "encoder", "artist", "date"}) {
    seen.tags += av_dict_get(container->metadata, tag, nullptr, 0) != nullptr;
    seen.tags += av_dict_get(stream.metadata, tag, nullptr, 0) != nullptr;
  }
  const AVCodec* decoder = avcodec_find_decoder(seen.codec);
  AVCodecContext* context = avcodec_alloc_context3(decoder);
  avcodec_parameters_to_context(context, stream.codecpar);
  EXPECT_EQ(avcodec_open2(context, decoder, nullptr), 0);
  AVPacket* packet = av_packet_alloc();
  AVFrame* frame = av_frame_alloc();
  const auto drain = [&] {
    while (avcodec_receive_frame(context, frame) == 0) {
      double sum = 0;
      for (int y = 0; y < frame->height; ++y) {
        for (int x = 0; x < frame->width; ++x) sum += frame->data[0][y * frame->linesize[0] + x];
      }
      seen.lumas.push_back(sum / frame->width / frame->height);
    }
  };
  while (av_read_frame(container, packet) == 0) {
    avcodec_send_packet(context, packet);
    av_packet_unref(packet);
    drain();
  }
  avcodec_send_packet(context, nullptr);
  drain();
  av_frame_free(&frame);
  av_packet_free(&packet);
  avcodec_free_context(&context);
  avformat_close_input(&container);
  return seen;
}

std::string video_of(const VideoFormat& format, const std::function<PictureRgb8(int)>& frame) {
  auto file = make_video_file(format);
  EXPECT_TRUE(file) << file.error().message;
  for (std::uint32_t i = 0; i < format.frames; ++i) {
    const auto added = (*file)->add(frame(static_cast<int>(i)));
    EXPECT_TRUE(added) << added.error().message;
  }
  auto bytes = (*file)->finish();
  EXPECT_TRUE(bytes) << bytes.error().message;
  return bytes ? *bytes : std::string();
}

TEST(VideoFile, ContainsEachFrameOnceInOrder) {
  constexpr Canvas kSize{64, 48};
  const Seen seen =
      seen_in(video_of(format_of(kSize, 40, 20), [&](int i) { return grey(kSize, 10 + 6 * i); }));
  EXPECT_EQ(seen.streams, 1) << "only a video stream";
  EXPECT_EQ(seen.codec, AV_CODEC_ID_H264);
  EXPECT_EQ(seen.pixel_format, AV_PIX_FMT_YUV420P);
  EXPECT_EQ(seen.size, kSize);
  EXPECT_NEAR(seen.seconds, 2, 1e-6);
  EXPECT_EQ(seen.tags, 0);
  ASSERT_EQ(seen.lumas.size(), 40u);
  for (std::size_t i = 0; i < 40; ++i) {
    EXPECT_NEAR(seen.lumas[i], 16 + 219.0 / 255 * double(10 + 6 * i), 2) << i;
  }
}

TEST(VideoFile, StoresTheIndexBeforeTheFrames) {
  constexpr Canvas kSize{64, 48};
  const std::string bytes =
      video_of(format_of(kSize, 30), [&](int i) { return smooth_picture(64, 48, i); });
  const auto index = bytes.find("moov"), pictures = bytes.find("mdat");
  ASSERT_NE(index, std::string::npos);
  ASSERT_NE(pictures, std::string::npos);
  EXPECT_LT(index, pictures);
}

// Noise compresses least.
TEST(VideoFile, LimitsItsSizeEvenForNoise) {
  constexpr Canvas kSize{320, 240};
  std::mt19937 random(1);
  const std::string bytes = video_of(format_of(kSize, 60, 10), [&](int) {
    PictureRgb8 picture = grey(kSize, 0);
    for (auto& value : picture.pixels) value = static_cast<std::uint8_t>(random());
    return picture;
  });
  EXPECT_GT(bytes.size(), 1u << 20);
  EXPECT_LT(bytes.size(), 24'000'000u / 8 * 6 * 11 / 10);
}

TEST(VideoFile, RefusesFrameOfAnotherSize) {
  auto file = make_video_file(format_of({64, 48}, 3));
  ASSERT_TRUE(file);
  EXPECT_FALSE((*file)->add(smooth_picture(48, 64)));
}

// The sanitizers detect leaks.
TEST(VideoFile, CanBeAbandonedBeforeTheEnd) {
  auto file = make_video_file(format_of({64, 48}, 30));
  ASSERT_TRUE(file);
  ASSERT_TRUE((*file)->add(smooth_picture(64, 48)));
}

}  // namespace
}  // namespace diaphane::render
