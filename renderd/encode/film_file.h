#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/result.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

struct FilmFormat {
  Canvas size;  ///< both sides even
  std::uint32_t frames_per_second = 25;
  std::uint32_t frames = 0;  ///< expected number
};

/// The maximum size of a film, which limits its bit rate.
inline constexpr std::size_t kMostFilmBytes = std::size_t{48} << 20;

/// Writes H.264 in MP4 with the index at the front (faststart), without sound or metadata. Keeps
/// the film in memory until it is complete. Not thread-safe.
class FilmFile {
 public:
  virtual ~FilmFile() = default;
  /// Appends a frame of the film's size.
  virtual Result<void> add(const PictureRgb8& picture) = 0;
  /// Returns the file. To be called once, after all frames.
  virtual Result<std::string> finish() = 0;
};

/// kUnsupported if FFmpeg was built without libx264.
Result<std::unique_ptr<FilmFile>> make_film_file(const FilmFormat& format);

}  // namespace diaphane::render
