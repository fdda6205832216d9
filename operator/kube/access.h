#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "common/result.h"

namespace diaphane::kube {

/// How an API server is reached, and as whom.
struct Access {
  std::string server;      ///< "https://host:port"
  std::string token_file;  ///< bound tokens are exchanged under it; empty: none
  std::string ca_file;     ///< empty: the system's
  std::string name_space;
};

/// As a pod has it (KUBERNETES_SERVICE_HOST and the mounted service account).
/// kUnavailable: this is no pod.
Result<Access> access_of_pod(const std::map<std::string, std::string>& environment,
                             const std::string& account_dir);

/// The token of a file, read again every minute. Thread-safe.
class Token {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::seconds kAge{60};
  explicit Token(std::string file) : file_(std::move(file)) {}
  /// Empty when there is none. A file that cannot be read for once leaves the token before.
  std::string at(Time now);
  /// It was refused: the next is read from the file.
  void refused();

 private:
  const std::string file_;
  std::mutex mutex_;
  std::string token_;
  std::optional<Time> read_;
};

}  // namespace diaphane::kube
