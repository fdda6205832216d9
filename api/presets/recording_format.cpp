#include "api/presets/recording_format.h"

namespace diaphane::api {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr std::size_t kMostEvents = 20'000;
constexpr std::size_t kMostKeptBytes = 1'048'576;  // maximum of recordings.body (migrations/0003)
constexpr std::int64_t kLongestPauseMs = 10'000;
constexpr int kDeepest = 12;
constexpr std::string_view kEnd = "]}";

/// Removes names and textures. Returns false if the value cannot be part of a scene.
bool strip(json& value, int depth) {
  if (depth > kDeepest) return false;
  if (value.is_object()) {
    value.erase("name");
    value.erase("picture");
    for (auto& [key, part] : value.items()) {
      if (key.size() > 64 || !strip(part, depth + 1)) return false;
    }
  } else if (value.is_array()) {
    for (json& part : value) {
      if (!strip(part, depth + 1)) return false;
    }
  } else if (value.is_string()) {
    // Keeps only enumeration values. User input contains a space or a lower-case letter somewhere.
    return value.get_ref<const std::string&>().find_first_not_of(
               "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") == std::string::npos;
  }
  return true;
}

bool is_count(const json& value, std::int64_t low, std::int64_t high) {
  if (!value.is_number_integer() || (value.is_number_unsigned() && value > high)) return false;
  return value.get<std::int64_t>() >= low && value.get<std::int64_t>() <= high;
}

/// Adds the events to `recording` in their stored form. Returns what is wrong with the first
/// invalid one, or an empty string. Serialises each event as soon as it is read, so that at most
/// one exists twice as a tree.
std::string read_events(const json& given, Recording& recording) {
  if (!given.is_array() || given.empty() || given.size() > kMostEvents) {
    return "must be a list of 1 to 20,000 events";
  }
  std::int64_t last_ms = 0;
  for (const json& event : given) {
    const bool first = recording.events == 0;
    const bool scene = event.is_object() && event.contains("scene");
    const bool camera = event.is_object() && event.contains("camera");
    if (!event.is_object() || event.size() != 2 || scene == camera || !event.contains("at_ms")) {
      return "must each have at_ms and either scene or camera";
    }
    if (first && !scene) return "must begin with an event that has a scene";
    if (!is_count(event["at_ms"], last_ms, last_ms + kLongestPauseMs) ||
        (first && event["at_ms"] != 0)) {
      return "must have times that start at 0, never decrease and have gaps of at most 10 s";
    }
    const char* what = scene ? "scene" : "camera";
    json look = event[what];
    if (!look.is_object() || !strip(look, 0)) return "contains an invalid scene";
    last_ms = event["at_ms"].get<std::int64_t>();
    recording.body += (first ? "" : ",") + ordered_json{{"at_ms", last_ms}, {what, look}}.dump();
    ++recording.events;
    // The limit includes the end of the document.
    if (recording.body.size() + kEnd.size() > kMostKeptBytes) {
      return "take more than 1 MiB when stored; make a shorter recording";
    }
  }
  recording.duration_ms = last_ms;
  return {};
}

}  // namespace

Recording read_recording(Fields& in) {
  Recording recording;
  const std::string format = in.text("format", 1, 64);
  if (format != "diaphane-interaction") in.wrong("format", "must be diaphane-interaction");
  const std::int64_t version = in.integer("version", 1, 1);
  const json& viewport = in.any("viewport");
  const bool sized = viewport.is_object() && viewport.size() == 2 && viewport.contains("width") &&
                     viewport.contains("height") && is_count(viewport["width"], 16, 4096) &&
                     is_count(viewport["height"], 16, 4096);
  if (!sized) in.wrong("viewport", "must have a width and a height from 16 to 4096");
  recording.body =
      ordered_json{{"format", format}, {"version", version}, {"viewport", viewport}}.dump();
  recording.body.back() = ',';
  recording.body += "\"events\":[";
  if (const std::string mistake = read_events(in.any("events"), recording); !mistake.empty()) {
    in.wrong("events", mistake);
  }
  recording.body += kEnd;
  return recording;
}

}  // namespace diaphane::api
