#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "common/result.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// Writes an RGB PNG row by row, without alpha, colour profile or text. Holds only a few rows in
/// memory. Every function returns kInternal if libpng fails, and kOutOfMemory. Not thread-safe.
class PngRows {
 public:
  virtual ~PngRows() = default;
  /// Appends complete rows, and returns the bytes of the file that are ready. Returns kInternal for
  /// part of a row or too many rows.
  virtual Result<std::string> add(std::span<const std::uint8_t> rgb) = 0;
  /// Returns the rest of the file. To be called once, after all rows.
  virtual Result<std::string> finish() = 0;
};

/// Creates a writer. `level` is the compression level of zlib, 0 to 9.
Result<std::unique_ptr<PngRows>> make_png_rows(Canvas size, int level);

}  // namespace diaphane::render
