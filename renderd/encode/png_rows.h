#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "common/result.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// A PNG that is written row by row: RGB without alpha, without colour profile and without text.
/// It holds a few rows, whatever the picture's height. Used by one thread at a time.
class PngRows {
 public:
  virtual ~PngRows() = default;
  /// The next rows, whole ones. The bytes of the file that are ready.
  virtual Result<std::string> add(std::span<const std::uint8_t> rgb) = 0;
  /// After all rows, once: the rest of the file.
  virtual Result<std::string> finish() = 0;
};

Result<std::unique_ptr<PngRows>> make_png_rows(Canvas size, int level);

}  // namespace diaphane::render
