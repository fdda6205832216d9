#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace diaphane::kube {

struct WatchEvent {
  enum class Type { kAdded, kModified, kDeleted, kBookmark, kExpired, kError };
  Type type = Type::kError;
  nlohmann::json object;  ///< a Status for kExpired and kError
};

/// Splits the bytes of a watch into events, one JSON object per line.
class WatchReader {
 public:
  /// Returns the events that `bytes` completes. After kError (an invalid line), the rest is
  /// unusable.
  std::vector<WatchEvent> feed(std::string_view bytes);

 private:
  static constexpr std::size_t kLongestLine = 16U << 20;
  std::string rest_;
};

WatchEvent read_event(std::string_view line);

/// Returns whether the answer to a list or watch says that the known version is too old, or too new
/// for a server that lags behind, so that everything must be listed again. `body` is a Status.
bool must_list_again(int status, const nlohmann::json& body);

/// Compares resource versions, which are increasing numbers of any length (KEP-5504). Returns a
/// negative number, 0 or a positive number.
int compare_versions(std::string_view a, std::string_view b);

}  // namespace diaphane::kube
