#include "renderd/encode/video_file.h"

#include <algorithm>
#include <cstring>

#include "common/try.h"
#include "renderd/encode/encoder.h"
#include "renderd/encode/ffmpeg.h"

extern "C" {
#include <libavformat/avformat.h>
}

namespace diaphane::render {
namespace {

constexpr double kRateFactor = 18;                     // no visible loss
constexpr std::int64_t kMostBitsASecond = 24'000'000;  // limit of phones
constexpr double kForFrames = 0.9;                     // share of the bytes; the rest is the index
constexpr int kBufferBytes = 1 << 16;

tl::unexpected<Error> failed(int error) {
  return fail(ErrorCode::kInternal,
              "The video could not be encoded: " + ffmpeg::error_text(error) + ".");
}
tl::unexpected<Error> no_memory() {
  return fail(ErrorCode::kOutOfMemory, "There is not enough memory to encode the video.");
}

std::int64_t most_bits_a_second(const VideoFormat& format) {
  const double seconds = static_cast<double>(format.frames) / format.frames_per_second;
  const double bits = 8.0 * kForFrames * static_cast<double>(kMostVideoBytes);
  return std::min(kMostBitsASecond, static_cast<std::int64_t>(bits / std::max(seconds, 1.0)));
}

/// A position in a file in memory, for FFmpeg's I/O callbacks.
class MemoryFile {
 public:
  explicit MemoryFile(std::string& bytes) : bytes_(bytes) {}

  static int read(void* opaque, std::uint8_t* to, int size) {
    auto& file = *static_cast<MemoryFile*>(opaque);
    const std::size_t left = file.bytes_.size() - std::min(file.at_, file.bytes_.size());
    const std::size_t count = std::min(left, static_cast<std::size_t>(size));
    if (count == 0) return AVERROR_EOF;
    std::memcpy(to, file.bytes_.data() + file.at_, count);
    file.at_ += count;
    return static_cast<int>(count);
  }
  static int write(void* opaque, std::uint8_t* from, int size) {
    auto& file = *static_cast<MemoryFile*>(opaque);
    const std::size_t end = file.at_ + static_cast<std::size_t>(size);
    if (end > kMostVideoBytes) return AVERROR(ENOSPC);
    if (end > file.bytes_.size()) file.bytes_.resize(end);
    std::memcpy(file.bytes_.data() + file.at_, from, static_cast<std::size_t>(size));
    file.at_ = end;
    return size;
  }
  static std::int64_t seek(void* opaque, std::int64_t offset, int whence) {
    auto& file = *static_cast<MemoryFile*>(opaque);
    const auto size = static_cast<std::int64_t>(file.bytes_.size());
    if (whence == AVSEEK_SIZE) return size;
    const std::int64_t from = whence == SEEK_SET   ? 0
                              : whence == SEEK_CUR ? static_cast<std::int64_t>(file.at_)
                                                   : size;
    if (from + offset < 0) return AVERROR(EINVAL);
    file.at_ = static_cast<std::size_t>(from + offset);
    return from + offset;
  }

 private:
  std::string& bytes_;
  std::size_t at_ = 0;
};

void free_io(AVIOContext* io) {
  if (!io) return;
  delete static_cast<MemoryFile*>(io->opaque);
  av_freep(&io->buffer);
  avio_context_free(&io);
}
struct FreeIo {
  void operator()(AVIOContext* io) const { free_io(io); }
};
using Io = std::unique_ptr<AVIOContext, FreeIo>;

Io open_io(std::string& bytes, bool writes) {
  auto file = std::make_unique<MemoryFile>(bytes);
  auto* buffer = static_cast<unsigned char*>(av_malloc(kBufferBytes));
  AVIOContext* io =
      buffer ? avio_alloc_context(buffer, kBufferBytes, writes ? 1 : 0, file.get(),
                                  &MemoryFile::read, &MemoryFile::write, &MemoryFile::seek)
             : nullptr;
  if (!io) {
    av_free(buffer);
    return nullptr;
  }
  (void)file.release();  // released by free_io
  return Io(io);
}

struct FreeFormat {
  void operator()(AVFormatContext* format) const { avformat_free_context(format); }
};

class Mp4File final : public VideoFile {
 public:
  explicit Mp4File(const VideoFormat& format) : format_(format) {}

  Result<void> open() {
    if (auto coder = open_coder(); !coder) return coder;
    return open_container();
  }

  Result<void> add(const PictureRgb8& picture) override {
    DIAPHANE_TRY(check_picture(picture));
    if (picture.size != format_.size) {
      return fail(ErrorCode::kInternal, "The size of a frame does not match its video.");
    }
    auto converted = converter_.convert(picture);
    DIAPHANE_TRY(converted);
    (*converted)->pts = next_++;
    return code(*converted);
  }

  Result<std::string> finish() override {
    DIAPHANE_TRY(code(nullptr));
    if (const int error = av_write_trailer(container_.get()); error < 0) return failed(error);
    avio_flush(io_.get());
    return std::move(bytes_);
  }

 private:
  Result<void> open_coder() {
    const AVCodec* codec = avcodec_find_encoder_by_name("libx264");
    if (!codec)
      return fail(ErrorCode::kUnsupported, "The server's FFmpeg does not include libx264.");
    coder_.reset(avcodec_alloc_context3(codec));
    packet_.reset(av_packet_alloc());
    if (!coder_ || !packet_) return no_memory();
    AVCodecContext& coder = *coder_;
    const int rate = static_cast<int>(format_.frames_per_second);
    ffmpeg::set_bt709(coder, format_.size, rate);
    coder.gop_size = rate;  // one key frame per second makes seeking fast
    coder.flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
    coder.rc_max_rate = most_bits_a_second(format_);
    coder.rc_buffer_size = static_cast<int>(coder.rc_max_rate / 2);
    av_opt_set(coder.priv_data, "profile", "high", 0);
    av_opt_set(coder.priv_data, "preset", "fast", 0);
    av_opt_set_double(coder.priv_data, "crf", kRateFactor, 0);
    const int opened = avcodec_open2(&coder, codec, nullptr);
    return opened < 0 ? failed(opened) : Result<void>();
  }

  Result<void> open_container() {
    AVFormatContext* container = nullptr;
    if (avformat_alloc_output_context2(&container, nullptr, "mp4", nullptr) < 0) return no_memory();
    container_.reset(container);
    io_ = open_io(bytes_, true);
    AVStream* stream = avformat_new_stream(container, nullptr);
    if (!io_ || !stream) return no_memory();
    container->pb = io_.get();
    container->flags |= AVFMT_FLAG_CUSTOM_IO | AVFMT_FLAG_BITEXACT;
    // For faststart, FFmpeg moves the whole file to make room for the index and reads it through
    // another context.
    container->opaque = this;
    container->io_open = [](AVFormatContext* of, AVIOContext** io, const char*, int,
                            AVDictionary**) {
      *io = open_io(static_cast<Mp4File*>(of->opaque)->bytes_, false).release();
      return *io ? 0 : AVERROR(ENOMEM);
    };
    container->io_close2 = [](AVFormatContext*, AVIOContext* io) {
      free_io(io);
      return 0;
    };
    stream->time_base = coder_->time_base;
    stream->avg_frame_rate = coder_->framerate;
    if (avcodec_parameters_from_context(stream->codecpar, coder_.get()) < 0) return no_memory();
    AVDictionary* options = nullptr;
    av_dict_set(&options, "movflags", "+faststart", 0);
    const int begun = avformat_write_header(container, &options);
    av_dict_free(&options);
    return begun < 0 ? failed(begun) : Result<void>();
  }

  /// Encodes a frame, or with nullptr flushes the encoder.
  Result<void> code(const AVFrame* frame) {
    int result = avcodec_send_frame(coder_.get(), frame);
    while (result >= 0) {
      result = avcodec_receive_packet(coder_.get(), packet_.get());
      if (result == AVERROR(EAGAIN) || result == AVERROR_EOF) return {};
      if (result < 0) break;
      packet_->duration = 1;
      av_packet_rescale_ts(packet_.get(), coder_->time_base, container_->streams[0]->time_base);
      result = av_write_frame(container_.get(), packet_.get());
      av_packet_unref(packet_.get());
    }
    return failed(result);
  }

  const VideoFormat format_;
  std::string bytes_;
  ffmpeg::YuvConverter converter_{ffmpeg::Matrix::kBt709};
  ffmpeg::Packet packet_;
  ffmpeg::Context coder_;
  Io io_;  // must outlive the container
  std::unique_ptr<AVFormatContext, FreeFormat> container_;
  std::int64_t next_ = 0;
};

}  // namespace

Result<std::unique_ptr<VideoFile>> make_video_file(const VideoFormat& format) {
  av_log_set_level(AV_LOG_QUIET);  // errors are returned as values instead
  auto file = std::make_unique<Mp4File>(format);
  DIAPHANE_TRY(file->open());
  return std::unique_ptr<VideoFile>(std::move(file));
}

}  // namespace diaphane::render
