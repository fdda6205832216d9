#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "common/result.h"

namespace diaphane::kube {

/// Address and credentials of an API server.
struct Access {
  std::string server;      ///< "https://host:port"
  std::string token_file;  ///< file with the bound token, which Kubernetes rotates; empty: none
  std::string ca_file;     ///< empty: the system's CAs
  std::string name_space;
};

/// Reads the access of a pod (KUBERNETES_SERVICE_HOST and the mounted service account). Returns
/// kUnavailable outside of a pod.
Result<Access> access_of_pod(const std::map<std::string, std::string>& environment,
                             const std::string& account_dir);

/// The token in a file, reread every minute. Thread-safe.
class Token {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::seconds kAge{60};
  explicit Token(std::string file) : file_(std::move(file)) {}
  /// Returns the token, or an empty string if there is none. If the file is temporarily unreadable,
  /// returns the previous token.
  std::string at(Time now);
  /// Records that the server rejected the token, so that the next call rereads the file.
  void refused();

 private:
  const std::string file_;
  std::mutex mutex_;
  std::string token_;
  std::optional<Time> read_;
};

}  // namespace diaphane::kube
