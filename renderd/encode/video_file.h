#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/result.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

struct VideoFormat {
  Canvas size;  ///< both sides even
  std::uint32_t frames_per_second = 25;
  std::uint32_t frames = 0;  ///< expected number
};

/// Maximum size of a video in bytes, which limits its bit rate.
inline constexpr std::size_t kMostVideoBytes = std::size_t{48} << 20;

/// Writes H.264 in MP4 with the index at the front (faststart), without sound or metadata. Keeps
/// the video in memory until it is complete. Not thread-safe.
class VideoFile {
 public:
  virtual ~VideoFile() = default;
  /// Appends a frame. Returns kInternal if it does not have the size of the video or FFmpeg fails,
  /// and kOutOfMemory.
  virtual Result<void> add(const PictureRgb8& picture) = 0;
  /// Returns the file. To be called once, after all frames. The errors are those of add().
  virtual Result<std::string> finish() = 0;
};

/// Creates an empty video. Fails with kUnsupported if FFmpeg was built without libx264.
Result<std::unique_ptr<VideoFile>> make_video_file(const VideoFormat& format);

}  // namespace diaphane::render
