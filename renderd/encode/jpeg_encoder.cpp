#include "renderd/encode/jpeg_encoder.h"

#include <turbojpeg.h>

#include <algorithm>

#include "common/try.h"

namespace diaphane::render {
namespace {

struct FreeHandle {
  void operator()(void* handle) const { tjDestroy(handle); }
};
struct FreeBuffer {
  void operator()(unsigned char* data) const { tjFree(data); }
};

constexpr int kMovingQuality = 80;
constexpr int kSettledQuality = 95;
constexpr int kLowestQuality = 25;

// Returns the quality at which a picture probably fits. libjpeg scales its tables by 5000 / quality
// below 50 and by 200 - 2 quality above. The size is roughly inverse to that scale.
int lower_quality(int quality, std::size_t bytes, std::size_t most) {
  const double scale = quality < 50 ? 5000.0 / quality : 200.0 - 2 * quality;
  const double target = scale * 1.3 * static_cast<double>(bytes) / static_cast<double>(most);
  const double next = target > 100 ? 5000 / target : (200 - target) / 2;
  return std::max(kLowestQuality, std::min(quality - 5, static_cast<int>(next)));
}

class JpegEncoder final : public Encoder {
 public:
  explicit JpegEncoder(tjhandle handle) : handle_(handle) {}

  Result<CodedFrame> encode(const PictureRgb8& picture, const EncodeRequest& request) override {
    DIAPHANE_TRY(check_picture(picture));
    const bool settled = request.quality == Quality::kSettled;
    // Starts slightly above the last quality that fitted, so that few pictures are encoded twice
    // and quality recovers quickly.
    int& last = settled ? settled_quality_ : moving_quality_;
    const int best = settled ? kSettledQuality : kMovingQuality;
    for (int quality = request.most_bytes == 0 ? best : std::min(best, last + 3);;) {
      auto coded = encode_at(picture, quality, settled);
      last = quality;
      const bool fits =
          !coded || request.most_bytes == 0 || coded->data.size() <= request.most_bytes;
      if (fits || quality <= kLowestQuality) return coded;
      quality = lower_quality(quality, coded->data.size(), request.most_bytes);
    }
  }

 private:
  Result<CodedFrame> encode_at(const PictureRgb8& picture, int quality, bool settled) {
    const Canvas size = picture.size;
    const int chroma = settled ? TJSAMP_444 : TJSAMP_420;
    const int width = static_cast<int>(size.width);
    const int height = static_cast<int>(size.height);
    const unsigned long most = tjBufSize(width, height, chroma);
    if (most > capacity_) {
      buffer_.reset(tjAlloc(static_cast<int>(most)));
      capacity_ = buffer_ ? most : 0;
      if (!buffer_)
        return fail(ErrorCode::kOutOfMemory, "There is not enough memory to encode an image.");
    }
    unsigned char* data = buffer_.get();
    unsigned long bytes = capacity_;
    const int flags = TJFLAG_NOREALLOC | (settled ? TJFLAG_ACCURATEDCT : TJFLAG_FASTDCT);
    if (tjCompress2(handle_.get(), picture.pixels.data(), width, 0, height, TJPF_RGB, &data, &bytes,
                    chroma, quality, flags) != 0) {
      return fail(ErrorCode::kInternal, "An image could not be encoded as JPEG.");
    }
    return CodedFrame{
        v1::JPEG, true, picture.size, std::string(reinterpret_cast<const char*>(data), bytes), {}};
  }

  std::unique_ptr<void, FreeHandle> handle_;
  std::unique_ptr<unsigned char, FreeBuffer> buffer_;
  unsigned long capacity_ = 0;
  int moving_quality_ = kMovingQuality;
  int settled_quality_ = kSettledQuality;
};

}  // namespace

Result<std::unique_ptr<Encoder>> make_jpeg_encoder() {
  const tjhandle handle = tjInitCompress();
  if (!handle)
    return fail(ErrorCode::kOutOfMemory, "There is not enough memory for the JPEG encoder.");
  return std::make_unique<JpegEncoder>(handle);
}

}  // namespace diaphane::render
