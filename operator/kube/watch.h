#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace diaphane::kube {

struct WatchEvent {
  enum class Type { kAdded, kModified, kDeleted, kBookmark, kExpired, kError };
  Type type = Type::kError;
  nlohmann::json object;  ///< of kExpired and kError: a Status
};

/// Cuts the bytes of a watch into its events, one JSON object a line.
class WatchReader {
 public:
  /// kError for a line that is none; nothing after it is of use.
  std::vector<WatchEvent> feed(std::string_view bytes);

 private:
  static constexpr std::size_t kLongestLine = 16U << 20;
  std::string rest_;
};

WatchEvent read_event(std::string_view line);

/// An answer to a list or a watch that says that what we know is too old, or, by a server that is
/// behind, too new: everything is listed again. `body` is a Status.
bool must_list_again(int status, const nlohmann::json& body);

/// Resource versions are numbers that grow (KEP-5504), of any length. Negative, 0, positive.
int compare_versions(std::string_view a, std::string_view b);

}  // namespace diaphane::kube
