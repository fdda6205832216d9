#include "renderd/encode/jpeg_encoder.h"

#include <turbojpeg.h>

namespace diaphane::render {
namespace {

struct FreeHandle {
  void operator()(void* handle) const { tjDestroy(handle); }
};
struct FreeBuffer {
  void operator()(unsigned char* data) const { tjFree(data); }
};

class JpegEncoder final : public Encoder {
 public:
  explicit JpegEncoder(tjhandle handle) : handle_(handle) {}

  Result<CodedFrame> encode(const PictureRgb8& picture, const EncodeRequest& request) override {
    const Canvas size = picture.size;
    if (size.width == 0 || size.height == 0 ||
        picture.pixels.size() != std::size_t{3} * size.width * size.height) {
      return fail(ErrorCode::kInternal, "A picture does not have the size that it says.");
    }
    const bool settled = request.quality == Quality::kSettled;
    const int chroma = settled ? TJSAMP_444 : TJSAMP_420;
    const int width = static_cast<int>(size.width);
    const int height = static_cast<int>(size.height);
    const unsigned long most = tjBufSize(width, height, chroma);
    if (most > capacity_) {
      buffer_.reset(tjAlloc(static_cast<int>(most)));
      capacity_ = buffer_ ? most : 0;
      if (!buffer_) return fail(ErrorCode::kOutOfMemory, "No memory to code a picture.");
    }
    unsigned char* data = buffer_.get();
    unsigned long bytes = capacity_;
    const int flags = TJFLAG_NOREALLOC | (settled ? TJFLAG_ACCURATEDCT : TJFLAG_FASTDCT);
    if (tjCompress2(handle_.get(), picture.pixels.data(), width, 0, height, TJPF_RGB, &data, &bytes,
                    chroma, settled ? 95 : 80, flags) != 0) {
      return fail(ErrorCode::kInternal, "A picture could not be coded.");
    }
    return CodedFrame{v1::JPEG, true, std::string(reinterpret_cast<const char*>(data), bytes)};
  }

 private:
  std::unique_ptr<void, FreeHandle> handle_;
  std::unique_ptr<unsigned char, FreeBuffer> buffer_;
  unsigned long capacity_ = 0;
};

}  // namespace

Result<std::unique_ptr<Encoder>> make_jpeg_encoder() {
  const tjhandle handle = tjInitCompress();
  if (!handle) return fail(ErrorCode::kOutOfMemory, "No memory for a JPEG encoder.");
  return std::make_unique<JpegEncoder>(handle);
}

Result<std::unique_ptr<Encoder>> make_encoder(v1::Codec codec) {
  if (codec == v1::JPEG) return make_jpeg_encoder();
  return fail(ErrorCode::kUnsupported, "This server does not have that picture format.");
}

}  // namespace diaphane::render
