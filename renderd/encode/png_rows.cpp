#include "renderd/encode/png_rows.h"

#include <png.h>

#include <utility>

#include "common/try.h"

namespace diaphane::render {
namespace {

tl::unexpected<Error> failed() {
  return fail(ErrorCode::kInternal, "An image could not be encoded as PNG.");
}

class LibpngRows final : public PngRows {
 public:
  LibpngRows(Canvas size, int level) : size_(size), level_(level) {}
  ~LibpngRows() override { png_destroy_write_struct(&png_, &info_); }
  LibpngRows(const LibpngRows&) = delete;
  LibpngRows& operator=(const LibpngRows&) = delete;

  Result<void> open() {
    png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    if (png_) info_ = png_create_info_struct(png_);
    if (!info_)
      return fail(ErrorCode::kOutOfMemory, "There is not enough memory to encode an image.");
    return begin() ? Result<void>() : failed();
  }

  Result<std::string> add(std::span<const std::uint8_t> rgb) override {
    const std::size_t row = std::size_t{3} * size_.width;
    const std::size_t rows = rgb.size() / row;
    if (rgb.size() % row != 0 || rows > size_.height - written_) {
      return fail(ErrorCode::kInternal, "The rows do not match the image.");
    }
    if (!write(rgb.data(), rows)) return failed();
    written_ += static_cast<std::uint32_t>(rows);
    return std::exchange(ready_, {});
  }

  Result<std::string> finish() override {
    if (written_ != size_.height || !end()) return failed();
    return std::exchange(ready_, {});
  }

 private:
  // libpng leaves each of these three functions by longjmp, so they must not create objects with
  // destructors.
  bool begin() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_write_fn(
        png_, &ready_,
        [](png_structp png, png_bytep data, png_size_t bytes) {
          static_cast<std::string*>(png_get_io_ptr(png))
              ->append(reinterpret_cast<const char*>(data), bytes);
        },
        nullptr);
    png_set_IHDR(png_, info_, size_.width, size_.height, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png_, level_);
    png_set_filter(png_, PNG_FILTER_TYPE_BASE, PNG_FILTER_PAETH);
    png_write_info(png_, info_);
    return true;
  }
  bool write(const std::uint8_t* row, std::size_t rows) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    for (std::size_t y = 0; y < rows; ++y) {
      png_write_row(png_, row + std::size_t{3} * size_.width * y);
    }
    return true;
  }
  bool end() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_write_end(png_, info_);
    return true;
  }

  const Canvas size_;
  const int level_;
  std::string ready_;
  std::uint32_t written_ = 0;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

}  // namespace

Result<std::unique_ptr<PngRows>> make_png_rows(Canvas size, int level) {
  auto rows = std::make_unique<LibpngRows>(size, level);
  DIAPHANE_TRY(rows->open());
  return std::unique_ptr<PngRows>(std::move(rows));
}

}  // namespace diaphane::render
