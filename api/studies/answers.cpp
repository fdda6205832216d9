#include "api/studies/answers.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

namespace diaphane::api {
namespace {

using nlohmann::json;

constexpr std::size_t kMostWords = 2000;  ///< characters
/// A camera farther away than 100 m does not show a body.
constexpr double kFarthestMm = 100'000;
constexpr std::int64_t kLongestTrialMs = 3'600'000;
constexpr double kShortestDirection =
    1e-6;  ///< mm; a shorter one has no direction in single precision

/// Returns what is wrong with a value, or an empty string.
using Check = std::function<std::string(const json& step, const json& value)>;

bool has_only(const json& value, const std::vector<std::string>& keys) {
  return value.is_object() && value.size() == keys.size() &&
         std::ranges::all_of(keys, [&](const std::string& key) { return value.contains(key); });
}

bool is_integer(const json& value, std::int64_t low, std::int64_t high) {
  if (!value.is_number_integer()) return false;
  if (value.is_number_unsigned() && value.get<std::uint64_t>() > INT64_MAX) return false;
  return value.get<std::int64_t>() >= low && value.get<std::int64_t>() <= high;
}

bool is_number(const json& value, double low, double high) {
  return value.is_number() && value.get<double>() >= low && value.get<double>() <= high;
}

bool is_colour(const json& value) {
  if (!value.is_string()) return false;
  const auto& text = value.get_ref<const std::string&>();
  return text.size() == 7 && text[0] == '#' &&
         text.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
}

std::size_t characters(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

bool is_point(const json& value) {
  return value.is_array() && value.size() == 3 && std::ranges::all_of(value, [](const json& one) {
           return is_number(one, -kFarthestMm, kFarthestMm);
         });
}

/// Returns whether eye, target and up define a view.
bool is_camera(const json& value) {
  if (!has_only(value, {"eye", "target", "up"}) || !is_point(value["eye"]) ||
      !is_point(value["target"]) || !is_point(value["up"])) {
    return false;
  }
  std::array<double, 3> away{}, up{};
  for (std::size_t i = 0; i < 3; ++i) {
    away[i] = value["eye"][i].get<double>() - value["target"][i].get<double>();
    up[i] = value["up"][i].get<double>();
  }
  const std::array<double, 3> side{away[1] * up[2] - away[2] * up[1],
                                   away[2] * up[0] - away[0] * up[2],
                                   away[0] * up[1] - away[1] * up[0]};
  const auto length = [](const std::array<double, 3>& v) { return std::hypot(v[0], v[1], v[2]); };
  return length(away) > kShortestDirection && length(up) > kShortestDirection &&
         length(side) > kShortestDirection * length(away) * length(up);
}

std::set<std::string> ids_of(const json& list) {
  std::set<std::string> ids;
  for (const json& one : list) ids.insert(one["id"].get<std::string>());
  return ids;
}

/// Returns whether `value` lists distinct members of `known`.
bool is_subset(const json& value, const std::set<std::string>& known) {
  std::set<std::string> seen;
  return value.is_array() && std::ranges::all_of(value, [&](const json& one) {
           return one.is_string() && known.contains(one.get<std::string>()) &&
                  seen.insert(one.get<std::string>()).second;
         });
}

std::string check_text(const json&, const json& value) {
  return has_only(value, {}) ? "" : "must be an empty object";
}

std::string check_rating(const json& step, const json& value) {
  const bool valid =
      has_only(value, {"rating"}) && is_integer(value["rating"], step["low"], step["high"]);
  return valid ? "" : "must have a rating within the scale of the step";
}

std::string check_colours(const json& step, const json& value) {
  if (!has_only(value, {"colours"}) || !value["colours"].is_array() ||
      value["colours"].size() != step["materials"].size()) {
    return "must have one colour for each material";
  }
  std::set<std::string> channels;
  for (const json& material : step["materials"]) channels.insert(material["channel"]);
  for (const json& one : value["colours"]) {
    if (!has_only(one, {"channel", "from", "to"}) || !one["channel"].is_string() ||
        channels.erase(one["channel"].get<std::string>()) == 0 || !is_colour(one["from"]) ||
        !is_colour(one["to"])) {
      return "must have a channel, from and to for each material";
    }
  }
  return "";
}

std::string check_order(const json& step, const json& value) {
  const auto ids = ids_of(step["pictures"]);
  const bool valid = has_only(value, {"order", "shown"}) && is_subset(value["order"], ids) &&
                     is_subset(value["shown"], ids) && value["order"].size() == ids.size() &&
                     value["shown"].size() == ids.size();
  return valid ? "" : "must list all pictures, once in order and once as shown";
}

std::string check_viewpoint(const json&, const json& value) {
  const bool valid = has_only(value, {"camera", "start"}) && is_camera(value["camera"]) &&
                     is_camera(value["start"]);
  return valid ? "" : "must have two cameras, camera and start";
}

std::string check_choice(const json& step, const json& value) {
  const bool multiple = step["multiple"].get<bool>();
  const bool valid = has_only(value, {"choice"}) &&
                     is_subset(value["choice"], ids_of(step["options"])) &&
                     (multiple || value["choice"].size() == 1);
  return valid ? "" : "must list options of the step";
}

std::string check_words(const json&, const json& value) {
  const bool valid = has_only(value, {"words"}) && value["words"].is_string() &&
                     characters(value["words"].get_ref<const std::string&>()) <= kMostWords;
  return valid ? "" : "must have words of at most 2,000 characters";
}

bool is_trial(const json& trial) {
  return has_only(trial, {"delay_ms", "time_ms", "error_degrees", "acceptable", "rating"}) &&
         trial["delay_ms"].is_number_integer() && is_number(trial["time_ms"], 0, kLongestTrialMs) &&
         is_number(trial["error_degrees"], 0, 180) && trial["acceptable"].is_boolean() &&
         is_integer(trial["rating"], 0, 10);
}

std::string check_latency(const json& step, const json& value) {
  const json& delays = step["delays_ms"];
  if (!has_only(value, {"trials"}) || !value["trials"].is_array() ||
      value["trials"].size() != delays.size()) {
    return "must have one trial for each delay";
  }
  std::multiset<std::int64_t> left;
  for (const json& delay : delays) left.insert(delay.get<std::int64_t>());
  for (const json& trial : value["trials"]) {
    if (!is_trial(trial)) return "must have trials with all their fields";
    const auto found = left.find(trial["delay_ms"].get<std::int64_t>());
    if (found == left.end()) return "must have one trial for each delay";
    left.erase(found);
  }
  return "";
}

}  // namespace

const json* find_step(const json& definition, const std::string& id) {
  for (const json& step : definition["steps"]) {
    if (step["id"] == id) return &step;
  }
  return nullptr;
}

Outcome<std::string> check_answer(const json& step, const json& value) {
  static const std::map<std::string, Check> kChecks{
      {"text", check_text},   {"rating", check_rating},       {"colours", check_colours},
      {"order", check_order}, {"viewpoint", check_viewpoint}, {"choice", check_choice},
      {"words", check_words}, {"latency", check_latency}};
  const auto check = kChecks.find(step["kind"].get<std::string>());
  if (check == kChecks.end()) return refuse_field("step", "has no answer");
  if (const std::string mistake = check->second(step, value); !mistake.empty()) {
    return refuse_field("value", mistake);
  }
  std::string kept = value.dump();
  if (kept.size() > kMostAnswerBytes) return refuse_field("value", "is too large (16 KiB at most)");
  return kept;
}

}  // namespace diaphane::api
