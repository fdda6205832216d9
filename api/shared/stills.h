#pragma once

#include <cstdint>
#include <string>

#include "common/result.h"

namespace diaphane::api {

struct StillRequest {
  std::string data_set_id;
  std::string preset;      ///< name of a built-in preset, if there is no scene
  std::string scene = {};  ///< a serialised diaphane.v1.Scene
  std::uint32_t width = 480, height = 480;
  std::uint32_t samples = 256;  ///< maximum per pixel
  /// Estimated error at which rendering stops; 0 renders all samples. The picture is denoised, so
  /// that little of this error is visible.
  double error = 0.03;
  bool background = false;  ///< lower priority, because no user waits for it
};

/// Renders pictures without a session, such as thumbnails. Thread-safe. Blocks for up to 20 s, or
/// 60 s in the background.
class Stills {
 public:
  virtual ~Stills() = default;
  /// Returns JPEG bytes, kUnavailable if no worker responds, kNotFound if the worker has no such
  /// volume, or kInvalid for an unknown preset or a malformed scene.
  virtual Result<std::string> render(const StillRequest& request) = 0;
};

}  // namespace diaphane::api
