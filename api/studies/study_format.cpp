#include "api/studies/study_format.h"

#include <algorithm>
#include <functional>
#include <map>
#include <set>

#include "api/presets/preset_format.h"
#include "api/routing/representations.h"
#include "common/ids.h"

namespace diaphane::api {
namespace {

using nlohmann::json;

constexpr std::size_t kMostDefinitionBytes = 1'000'000;  ///< migrations/0028
constexpr std::size_t kMostSteps = 100;
constexpr std::size_t kTitleLength = 120, kTextLength = 2000, kNameLength = 120;
constexpr std::size_t kMostMaterials = 8, kMostOrdered = 10, kMostOptions = 20, kMostDelays = 20;
constexpr int kLongestDelayMs = 400;
constexpr int kMostPlaces = 1000;
constexpr std::chrono::hours kLongestStudy{24 * 366};
constexpr double kFarthestMm = 100'000;

constexpr std::array<std::string_view, 6> kTemplates{"comfort", "validation", "viewpoints",
                                                     "latency", "sus",        "own"};
constexpr std::array<std::string_view, 3> kChanges{"camera", "colours", "lights"};

bool is_slug(const json& value) {
  if (!value.is_string()) return false;
  const auto& text = value.get_ref<const std::string&>();
  return !text.empty() && text.size() <= 40 &&
         text.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") == std::string::npos;
}

bool is_integer(const json& value, std::int64_t low, std::int64_t high) {
  if (!value.is_number_integer()) return false;
  if (value.is_number_unsigned() && value.get<std::uint64_t>() > INT64_MAX) return false;
  return value.get<std::int64_t>() >= low && value.get<std::int64_t>() <= high;
}

/// Reads one definition. Collects the errors of all steps, with their JSON paths.
class DefinitionReader {
 public:
  DefinitionReader(Fields& in, json& definition) : in_(in), definition_(definition) {}

  void read(Time now) {
    if (!is_record("definition", definition_,
                   {"version", "template", "title", "places", "ends_at", "record", "steps"}, {})) {
      return;
    }
    if (definition_["version"] != 1) wrong("definition.version", "must be 1");
    check_choice("definition.template", definition_["template"], kTemplates);
    check_text("definition.title", definition_["title"], kTitleLength);
    if (!is_integer(definition_["places"], 1, kMostPlaces)) {
      wrong("definition.places", "must be a number from 1 to 1,000");
    }
    if (!definition_["record"].is_boolean()) wrong("definition.record", "must be true or false");
    read_end(now);
    read_steps();
  }

  Time ends_at() const { return ends_at_; }

 private:
  void wrong(const std::string& field, const std::string& message) { in_.wrong(field, message); }

  /// Returns whether the value is an object with all fields of `required`, and no others than those
  /// of `optional`.
  bool is_record(const std::string& field, const json& value, const std::set<std::string>& required,
                 const std::set<std::string>& optional) {
    if (!value.is_object()) {
      wrong(field, "must be an object");
      return false;
    }
    for (const std::string& key : required) {
      if (value.contains(key)) continue;
      wrong(field + "." + key, "is missing");
      return false;
    }
    for (const auto& [key, part] : value.items()) {
      if (required.contains(key) || optional.contains(key)) continue;
      wrong(field, "contains an unknown field");
      return false;
    }
    return true;
  }

  template <std::size_t N>
  void check_choice(const std::string& field, const json& value,
                    const std::array<std::string_view, N>& known) {
    if (value.is_string() &&
        std::ranges::find(known, value.get_ref<const std::string&>()) != known.end()) {
      return;
    }
    wrong(field, "is not one of the known values");
  }

  void check_text(const std::string& field, const json& value, std::size_t most) {
    if (!is_record(field, value, {}, {"en", "de"})) return;
    if (value.empty()) return wrong(field, "must have a text in en or de");
    for (const auto& [language, text] : value.items()) {
      const std::size_t length = !text.is_string()
                                     ? 0
                                     : static_cast<std::size_t>(std::ranges::count_if(
                                           text.get_ref<const std::string&>(), [](char c) {
                                             return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
                                           }));
      if (length < 1 || length > most) {
        wrong(field + "." + language, "must have 1 to " + std::to_string(most) + " characters");
      }
    }
  }

  void read_end(Time now) {
    const json& given = definition_["ends_at"];
    const auto time = given.is_string() ? time_of(given.get<std::string>()) : std::nullopt;
    if (!time)
      return wrong("definition.ends_at", "must be a UTC time such as 2026-11-22T10:00:00Z");
    if (*time > now + kLongestStudy) {
      return wrong("definition.ends_at", "must be at most one year ahead");
    }
    ends_at_ = *time;
  }

  void read_steps() {
    json& steps = definition_["steps"];
    if (!steps.is_array() || steps.empty() || steps.size() > kMostSteps) {
      return wrong("definition.steps", "must be a list of 1 to 100 steps");
    }
    std::set<std::string> ids;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const std::string field = "definition.steps[" + std::to_string(i) + "]";
      if (!read_step(field, steps[i])) continue;
      if ((steps[i]["kind"] == "consent") != (i == 0)) {
        wrong(field + ".kind", "must be consent for the first step and for no other");
      }
      if (!ids.insert(steps[i]["id"].get<std::string>()).second) {
        wrong(field + ".id", "must be unique");
      }
    }
    if (pictures_.size() > kMostStudyPictures) {
      wrong("definition.steps", "must have at most 20 pictures together");
    }
  }

  /// The fields of a kind of step, besides those of every step.
  struct Kind {
    std::set<std::string> required, optional;
    void (DefinitionReader::*check)(const std::string& field, json& step);
  };

  bool read_step(const std::string& field, json& step) {
    static const std::map<std::string, Kind> kKinds{
        {"consent", {{}, {}, nullptr}},
        {"text", {{}, {}, nullptr}},
        {"words", {{}, {}, nullptr}},
        {"rating",
         {{"low", "high", "low_text", "high_text"}, {"view"}, &DefinitionReader::check_rating}},
        {"colours", {{"view", "materials"}, {}, &DefinitionReader::check_colours}},
        {"order", {{"pictures"}, {}, &DefinitionReader::check_order}},
        {"viewpoint", {{"view"}, {}, nullptr}},
        {"choice", {{"options", "multiple"}, {}, &DefinitionReader::check_options}},
        {"latency", {{"view", "delays_ms"}, {}, &DefinitionReader::check_latency}}};
    if (!step.is_object() || !step.contains("kind") || !step["kind"].is_string()) {
      wrong(field + ".kind", "is missing");
      return false;
    }
    const auto kind = kKinds.find(step["kind"].get<std::string>());
    if (kind == kKinds.end()) {
      wrong(field + ".kind", "is not one of the known values");
      return false;
    }
    std::set<std::string> required = kind->second.required;
    required.insert({"id", "kind", "group", "text"});
    if (!is_record(field, step, required, kind->second.optional)) return false;
    if (!is_slug(step["id"])) {
      wrong(field + ".id", "must be 1 to 40 characters of a-z, 0-9 and '-'");
      return false;
    }
    const bool alone =
        step["group"].is_string() && step["group"].get_ref<const std::string&>().empty();
    if (!alone && !is_slug(step["group"])) {
      wrong(field + ".group", "must be empty or 1 to 40 characters of a-z, 0-9 and '-'");
    }
    check_text(field + ".text", step["text"], kTextLength);
    if (step.contains("view")) check_view(field + ".view", step["view"]);
    if (kind->second.check) (this->*kind->second.check)(field, step);
    return true;
  }

  void check_view(const std::string& field, json& view) {
    if (!is_record(field, view, {"data_set_id", "scene", "preset", "may_change", "start"},
                   {"region"})) {
      return;
    }
    if (!view["data_set_id"].is_string() || !is_id(view["data_set_id"].get<std::string>())) {
      wrong(field + ".data_set_id", "must be an ID");
    }
    auto scene = kept_scene(view["scene"]);
    if (scene) {
      view["scene"] = json::parse(*scene);
    } else {
      wrong(field + ".scene", scene.error().message.substr(0, 300));
    }
    const json& preset = view["preset"];
    if (!preset.is_string() || preset.get_ref<const std::string&>().size() > 4 * kNameLength) {
      wrong(field + ".preset", "must have at most 120 characters");
    }
    check_choice(field + ".start", view["start"],
                 std::array<std::string_view, 2>{"preset", "random"});
    const json& changes = view["may_change"];
    std::set<json> seen;
    if (!changes.is_array() || !std::ranges::all_of(changes, [&](const json& one) {
          return one.is_string() &&
                 std::ranges::find(kChanges, one.get<std::string>()) != kChanges.end() &&
                 seen.insert(one).second;
        })) {
      wrong(field + ".may_change", "must list camera, colours or lights");
    }
    if (view.contains("region")) check_region(field + ".region", view["region"]);
  }

  void check_region(const std::string& field, const json& region) {
    if (!is_record(field, region, {"name", "centre", "radius"}, {})) return;
    check_text(field + ".name", region["name"], kNameLength);
    const json& centre = region["centre"];
    const auto is_near = [](const json& one) {
      return one.is_number() && std::abs(one.get<double>()) <= kFarthestMm;
    };
    if (!centre.is_array() || centre.size() != 3 || !std::ranges::all_of(centre, is_near)) {
      wrong(field + ".centre", "must be three numbers in mm");
    }
    if (!is_near(region["radius"]) || region["radius"].get<double>() <= 0) {
      wrong(field + ".radius", "must be a positive number in mm");
    }
  }

  void check_rating(const std::string& field, json& step) {
    if (!is_integer(step["low"], 0, 100) || !is_integer(step["high"], 0, 100) ||
        step["low"] >= step["high"]) {
      wrong(field + ".low", "must be less than high, both from 0 to 100");
    }
    check_text(field + ".low_text", step["low_text"], kTextLength);
    check_text(field + ".high_text", step["high_text"], kTextLength);
  }

  void check_colours(const std::string& field, json& step) {
    const json& materials = step["materials"];
    if (!materials.is_array() || materials.empty() || materials.size() > kMostMaterials) {
      return wrong(field + ".materials", "must be a list of 1 to 8 materials");
    }
    std::set<json> channels;
    for (const json& one : materials) {
      if (!is_record(field + ".materials", one, {"channel", "name"}, {})) continue;
      const bool named = one["channel"].is_string() &&
                         !one["channel"].get_ref<const std::string&>().empty() &&
                         one["channel"].get_ref<const std::string&>().size() <= kNameLength;
      if (!named || !channels.insert(one["channel"]).second) {
        wrong(field + ".materials", "must each have a different channel");
      }
      check_text(field + ".materials.name", one["name"], kNameLength);
    }
  }

  void check_order(const std::string& field, json& step) {
    const json& pictures = step["pictures"];
    if (!pictures.is_array() || pictures.size() < 2 || pictures.size() > kMostOrdered) {
      return wrong(field + ".pictures", "must be a list of 2 to 10 pictures");
    }
    std::set<json> ids;
    for (const json& one : pictures) {
      if (!is_record(field + ".pictures", one, {"id", "comfort"}, {})) continue;
      if (!is_slug(one["id"]) || !ids.insert(one["id"]).second) {
        wrong(field + ".pictures", "must each have a different id");
        continue;
      }
      pictures_.insert(one["id"].get<std::string>());
      const json& comfort = one["comfort"];
      if (!comfort.is_number() || comfort.get<double>() < -2 || comfort.get<double>() > 2) {
        wrong(field + ".pictures", "must each have a comfort from -2 to 2");
      }
    }
  }

  void check_options(const std::string& field, json& step) {
    const json& options = step["options"];
    if (!step["multiple"].is_boolean()) wrong(field + ".multiple", "must be true or false");
    if (!options.is_array() || options.size() < 2 || options.size() > kMostOptions) {
      return wrong(field + ".options", "must be a list of 2 to 20 options");
    }
    std::set<json> ids;
    for (const json& one : options) {
      if (!is_record(field + ".options", one, {"id", "text"}, {})) continue;
      if (!is_slug(one["id"]) || !ids.insert(one["id"]).second) {
        wrong(field + ".options", "must each have a different id");
      }
      check_text(field + ".options.text", one["text"], kTextLength);
    }
  }

  /// Whether the region of a valid view is on one side of the camera's target, so that it can be
  /// turned to the front.
  static bool marks_a_side(const json& view) {
    constexpr double kNearestMm = 1;
    if (!view.is_object() || !view.contains("region")) return false;
    if (!view["region"].is_object() || !view["scene"].is_object()) return false;
    const json centre = view["region"].value("centre", json());
    const json target = view["scene"].value(json::json_pointer("/camera/target"), json::object());
    if (!centre.is_array() || centre.size() != 3) return false;
    constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
    double squared = 0;
    for (std::size_t i = 0; i < kAxes.size(); ++i) {
      if (!centre[i].is_number()) return false;
      const double part = centre[i].get<double>() - target.value(kAxes[i], 0.0);
      squared += part * part;
    }
    return squared > kNearestMm * kNearestMm;
  }

  void check_latency(const std::string& field, json& step) {
    const json& delays = step["delays_ms"];
    if (!delays.is_array() || delays.empty() || delays.size() > kMostDelays ||
        !std::ranges::all_of(delays,
                             [](const json& d) { return is_integer(d, 0, kLongestDelayMs); })) {
      wrong(field + ".delays_ms", "must be a list of 1 to 20 delays from 0 to 400 ms");
    }
    if (step["view"].is_object() && step["view"].contains("start") &&
        step["view"]["start"] != "random") {
      wrong(field + ".view.start", "must be random");
    }
    if (!marks_a_side(step["view"])) {
      wrong(field + ".view.region",
            "must be there and its centre more than 1 mm from the camera's target");
    }
  }

  Fields& in_;
  json& definition_;
  Time ends_at_{};
  std::set<std::string> pictures_;
};

}  // namespace

StudyContent read_definition(Fields& in, Time now) {
  json definition = in.any("definition");
  if (definition.is_null()) {
    in.wrong("definition", "must be an object");
    return {};
  }
  DefinitionReader reader(in, definition);
  reader.read(now);
  StudyContent content;
  content.definition = definition.dump();
  // The tree of a body of 1 MB may be larger when it is written out again.
  if (content.definition.size() > kMostDefinitionBytes) {
    in.wrong("definition", "is too large (1 MB at most)");
  }
  content.ends_at = reader.ends_at();
  if (definition.is_object()) {
    if (definition.contains("title")) content.title = definition["title"].dump();
    const json places = definition.value("places", json());
    if (is_integer(places, 1, kMostPlaces)) content.places = places.get<int>();
  }
  return content;
}

json definition_for_participants(const std::string& definition) {
  json shown = json::parse(definition);
  for (json& step : shown["steps"]) {
    if (step.contains("view")) step["view"].erase("preset");
    if (!step.contains("pictures")) continue;
    for (json& picture : step["pictures"]) picture.erase("comfort");
  }
  return shown;
}

}  // namespace diaphane::api
