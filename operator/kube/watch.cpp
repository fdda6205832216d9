#include "operator/kube/watch.h"

#include <algorithm>

#include "operator/kube/fields.h"

namespace diaphane::kube {
namespace {

using nlohmann::json;

int code_of(const json& status) {
  const json& code = part(status, "code");
  return code.is_number_integer() ? code.get<int>() : 0;
}

}  // namespace

bool must_list_again(int status, const json& body) {
  if (status == 410) return true;
  if (!body.is_object()) return false;
  const std::string reason = text(body, "reason");
  if (reason == "Expired" || reason == "Gone" || code_of(body) == 410) return true;
  if (text(body, "message").find("Too large resource version") != std::string::npos) return true;
  const json& causes = part(part(body, "details"), "causes");
  return causes.is_array() && std::any_of(causes.begin(), causes.end(), [](const json& cause) {
           return text(cause, "reason") == "ResourceVersionTooLarge";
         });
}

WatchEvent read_event(std::string_view line) {
  json parsed = json::parse(line, nullptr, false);
  if (!parsed.is_object() || !parsed.contains("object") || !parsed["object"].is_object()) {
    return {};
  }
  WatchEvent event;
  const std::string type = text(parsed, "type");
  event.object = std::move(parsed["object"]);
  if (type == "ADDED") {
    event.type = WatchEvent::Type::kAdded;
  } else if (type == "MODIFIED") {
    event.type = WatchEvent::Type::kModified;
  } else if (type == "DELETED") {
    event.type = WatchEvent::Type::kDeleted;
  } else if (type == "BOOKMARK") {
    event.type = WatchEvent::Type::kBookmark;
  } else if (must_list_again(code_of(event.object), event.object)) {
    event.type = WatchEvent::Type::kExpired;
  }
  return event;
}

std::vector<WatchEvent> WatchReader::feed(std::string_view bytes) {
  std::vector<WatchEvent> events;
  rest_.append(bytes);
  std::size_t begin = 0;
  for (std::size_t end = rest_.find('\n'); end != std::string::npos;
       end = rest_.find('\n', begin)) {
    const std::string_view line = std::string_view(rest_).substr(begin, end - begin);
    begin = end + 1;
    if (!line.empty()) events.push_back(read_event(line));
  }
  rest_.erase(0, begin);
  if (rest_.size() > kLongestLine) {
    rest_.clear();
    events.emplace_back();
  }
  return events;
}

int compare_versions(std::string_view a, std::string_view b) {
  const auto trimmed = [](std::string_view text) {
    while (!text.empty() && text.front() == '0') text.remove_prefix(1);
    return text;
  };
  a = trimmed(a);
  b = trimmed(b);
  if (a.size() != b.size()) return a.size() < b.size() ? -1 : 1;
  return a.compare(b);
}

}  // namespace diaphane::kube
