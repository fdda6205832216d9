#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/proto/stream.pb.h"
#include "common/result.h"
#include "renderd/encode/file_marks.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// The next picture that a file needs.
struct FileStep {
  std::shared_ptr<const diaphane::v1::Scene> scene;
  Canvas canvas;
  std::uint32_t samples = 1;  ///< per pixel, at most
  double error = 0;           ///< estimated error to reach; 0: render all samples
  bool smoothed = false;
};

/// Makes a file picture by picture. Errors are those of the encoder (png_rows.h, video_file.h). Not
/// thread-safe.
class FileMaker {
 public:
  virtual ~FileMaker() = default;
  /// Returns the next picture to render, or nullopt when all pictures have been taken.
  virtual std::optional<FileStep> next() = 0;
  /// Takes the picture of the last step and its number of samples. Returns the bytes of the file
  /// that are ready.
  virtual Result<std::string> take(const PictureRgb8& picture, std::uint64_t samples) = 0;
  /// Returns the rest of the file. To be called once, after the last picture.
  virtual Result<std::string> finish() = 0;
  /// Returns the progress of rendering, 0 to 1.
  virtual double done() const = 0;
};

/// Returns the number of rows per band of a large picture, small enough for a small film and short
/// samples.
std::uint32_t band_rows(Canvas picture);

inline constexpr std::uint64_t kBandPixels = std::uint64_t{1} << 20;

/// Creates the maker of a file of a scan with `phases` phases. Fails with kInvalid, naming a field
/// of the request or its key views.
Result<std::unique_ptr<FileMaker>> make_file_maker(const diaphane::v1::FileRequest& request,
                                                   std::vector<diaphane::v1::Scene> keys,
                                                   FileMarks marks = {}, std::uint32_t phases = 1);

}  // namespace diaphane::render
