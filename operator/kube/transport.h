#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <string_view>

#include "common/result.h"

namespace diaphane::kube {

struct Request {
  std::string method = "GET";
  std::string path{};   ///< from the root of the API server
  std::string query{};  ///< encoded, without the question mark
  std::string body{};   ///< JSON
  std::string content_type = "application/json";
};

struct Response {
  int status = 0;
  std::string body;
};

/// The wire to an API server. Thread-safe; a call blocks. kUnavailable: there was no answer, and
/// whether a write was done is not known.
class Transport {
 public:
  virtual ~Transport() = default;
  virtual Result<Response> call(const Request& request, std::chrono::milliseconds timeout) = 0;
  /// An answer without end: `bytes` is told that it begins, by nothing, and then each piece as it
  /// comes, while it returns true. The body
  /// of an answer that is not 200 is in the response, as of a call. `silence` without a byte ends
  /// it.
  virtual Result<Response> stream(const Request& request, std::chrono::milliseconds silence,
                                  const std::function<bool(std::string_view)>& bytes) = 0;
  /// Ends what is under way; whatever comes after fails at once.
  virtual void stop() = 0;
};

}  // namespace diaphane::kube
