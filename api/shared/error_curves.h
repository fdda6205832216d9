#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"

namespace diaphane::api {

/// The error of a session's current view after each pass (ErrorCurve in api/proto/stream.proto).
struct ErrorCurve {
  struct Point {
    std::uint64_t samples = 0;  ///< per pixel
    double seconds = 0;         ///< rendering time
    double error = 0;           ///< estimated relative RMSE
  };
  std::uint64_t epoch = 0;
  std::vector<Point> points;
};

/// The curves that the render workers keep. Thread-safe. Blocks for up to 5 s.
class ErrorCurves {
 public:
  virtual ~ErrorCurves() = default;
  /// Returns kNotFound if the worker does not have the session, and kUnavailable if the worker does
  /// not respond.
  virtual Result<ErrorCurve> find(const std::string& worker_id, const std::string& session_id) = 0;
};

}  // namespace diaphane::api
