#include "operator/kube/watch.h"

namespace diaphane::kube {
namespace {

using nlohmann::json;

std::string text_of(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

int number_of(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number_integer() ? found->get<int>() : 0;
}

}  // namespace

bool must_list_again(int status, const json& body) {
  if (status == 410) return true;
  if (!body.is_object()) return false;
  const std::string reason = text_of(body, "reason");
  if (reason == "Expired" || reason == "Gone" || number_of(body, "code") == 410) return true;
  if (text_of(body, "message").find("Too large resource version") != std::string::npos) return true;
  if (const auto details = body.find("details"); details != body.end() && details->is_object()) {
    const auto causes = details->find("causes");
    if (causes == details->end() || !causes->is_array()) return false;
    for (const json& cause : *causes) {
      if (cause.is_object() && text_of(cause, "reason") == "ResourceVersionTooLarge") return true;
    }
  }
  return false;
}

WatchEvent read_event(std::string_view line) {
  json parsed = json::parse(line, nullptr, false);
  if (!parsed.is_object() || !parsed.contains("object") || !parsed["object"].is_object()) {
    return {};
  }
  WatchEvent event;
  const std::string type = text_of(parsed, "type");
  event.object = std::move(parsed["object"]);
  if (type == "ADDED") {
    event.type = WatchEvent::Type::kAdded;
  } else if (type == "MODIFIED") {
    event.type = WatchEvent::Type::kModified;
  } else if (type == "DELETED") {
    event.type = WatchEvent::Type::kDeleted;
  } else if (type == "BOOKMARK") {
    event.type = WatchEvent::Type::kBookmark;
  } else if (must_list_again(number_of(event.object, "code"), event.object)) {
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
