#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/proto/stream.pb.h"
#include "common/result.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// A picture that a file needs next.
struct FileStep {
  std::shared_ptr<const diaphane::v1::Scene> scene;
  Canvas canvas;
  std::uint32_t samples = 1;  ///< per pixel, at most
  double error = 0;           ///< estimated, at which it is good enough; 0: all samples
  bool smoothed = false;
};

/// Makes a file of one picture after the other. Used by one thread at a time.
class FileMaker {
 public:
  virtual ~FileMaker() = default;
  /// Nothing: all pictures were there.
  virtual std::optional<FileStep> next() = 0;
  /// The picture of the newest step, with so many samples; the file's bytes that are ready.
  virtual Result<std::string> take(const PictureRgb8& picture, std::uint64_t samples) = 0;
  /// After the last picture, once: the rest of the bytes.
  virtual Result<std::string> finish() = 0;
  /// Of the rendering, 0 to 1.
  virtual double done() const = 0;
};

/// The rows of the bands that a large picture is rendered in: so few that a film of one is small
/// and a sample of it short.
std::uint32_t band_rows(Canvas picture);

inline constexpr std::uint64_t kBandPixels = std::uint64_t{1} << 20;

/// kInvalid names what is wrong with the order (FileWanted) or its key views.
Result<std::unique_ptr<FileMaker>> make_file_maker(const diaphane::v1::FileWanted& wanted,
                                                   std::vector<diaphane::v1::Scene> keys);

}  // namespace diaphane::render
