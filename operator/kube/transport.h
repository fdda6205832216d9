#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <string_view>

#include "common/result.h"

namespace diaphane::kube {

struct Request {
  std::string method = "GET";
  std::string path{};   ///< absolute path on the API server
  std::string query{};  ///< encoded, without the question mark
  std::string body{};   ///< JSON
  std::string content_type = "application/json";
};

struct Response {
  int status = 0;
  std::string body;
};

/// Connection to an API server. Thread-safe. Calls block. They return kUnavailable if there was no
/// response, so that it is unknown whether a write took effect, and kTooLarge if the response
/// exceeds the limit. A response with any HTTP status is not an error.
class Transport {
 public:
  virtual ~Transport() = default;
  virtual Result<Response> call(const Request& request, std::chrono::milliseconds timeout) = 0;
  /// Reads an endless response. Calls `bytes` with an empty view once headers arrive, then per
  /// chunk. `bytes` returns false to stop. `silence` without a byte ends the stream. If the status
  /// is not 200, the body is in the response, as for call().
  virtual Result<Response> stream(const Request& request, std::chrono::milliseconds silence,
                                  const std::function<bool(std::string_view)>& bytes) = 0;
  /// Ends all calls in progress. Later calls fail immediately.
  virtual void stop() = 0;
};

}  // namespace diaphane::kube
