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
  std::uint32_t frames = 0;  ///< that will come
};

/// At most so large is a film, whatever it shows: its rate is bounded by it.
inline constexpr std::size_t kMostFilmBytes = std::size_t{48} << 20;

/// H.264 in MP4: what a player needs to begin stands first (faststart), no sound, no metadata.
/// It is kept in memory until it is whole. Used by one thread at a time.
class FilmFile {
 public:
  virtual ~FilmFile() = default;
  /// The next frame, of the film's size.
  virtual Result<void> add(const PictureRgb8& picture) = 0;
  /// After all frames, once.
  virtual Result<std::string> finish() = 0;
};

/// kUnsupported where this FFmpeg has no libx264.
Result<std::unique_ptr<FilmFile>> make_film_file(const FilmFormat& format);

}  // namespace diaphane::render
