#include "bench/load/recording.h"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "common/try.h"

namespace diaphane::api::load {
namespace {

tl::unexpected<Error> wrong(const std::string& what) {
  return fail(ErrorCode::kInvalid, "the recording " + what);
}

template <typename Message>
bool parse(const nlohmann::json& json, Message& out) {
  return google::protobuf::util::JsonStringToMessage(json.dump(), &out).ok();
}

}  // namespace

Result<Recording> Recording::read(std::string_view text) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object() || json.value("format", nlohmann::json()) != "diaphane-interaction" ||
      json.value("version", nlohmann::json()) != 1) {
    return wrong("is not one, or its version is not supported");
  }
  Recording recording;
  const auto viewport = json.value("viewport", nlohmann::json::object());
  const auto side = [&](const char* name) -> std::uint32_t {
    const auto value = viewport.is_object() ? viewport.value(name, nlohmann::json()) : viewport;
    return value.is_number_unsigned() ? value.get<std::uint32_t>() : 0;
  };
  recording.width = side("width");
  recording.height = side("height");
  if (recording.width == 0 || recording.height == 0) return wrong("has no size of the window");
  const auto events = json.value("events", nlohmann::json());
  if (!events.is_array() || events.empty()) return wrong("has no events");
  for (const auto& event : events) {
    if (!event.is_object() || !event.contains("at_ms") || !event["at_ms"].is_number_unsigned()) {
      return wrong("has an event without a time");
    }
    diaphane::v1::Scene scene;
    diaphane::v1::Camera camera;
    const bool whole = event.contains("scene") && parse(event["scene"], scene);
    const bool moved = event.contains("camera") && parse(event["camera"], camera);
    if (!whole && !moved) return wrong("has an event without a scene and without a camera");
    DIAPHANE_TRY(recording.add(whole ? &scene : nullptr, &camera,
                               event["at_ms"].get<std::uint32_t>() / 1000.0));
  }
  return recording;
}

Result<void> Recording::add(const diaphane::v1::Scene* scene, const diaphane::v1::Camera* camera,
                            double seconds) {
  if (scene != nullptr) scenes_.push_back(*scene);
  if (scenes_.empty()) return wrong("does not begin with a scene");
  if (!inputs_.empty() && seconds < inputs_.back().seconds) return wrong("goes back in time");
  inputs_.push_back({seconds, scenes_.size() - 1, scene != nullptr ? scene->camera() : *camera});
  return {};
}

diaphane::v1::Scene Recording::scene(std::size_t input) const {
  diaphane::v1::Scene scene = scenes_[inputs_[input].scene];
  *scene.mutable_camera() = inputs_[input].camera;
  return scene;
}

double Recording::gap_after(std::size_t input) const {
  if (input + 1 >= inputs_.size()) return 0;
  const double gap = inputs_[input + 1].seconds - inputs_[input].seconds;
  // Inputs of the same millisecond still follow each other.
  return gap > kGestureGap ? 0 : std::max(gap, 0.001);
}

}  // namespace diaphane::api::load
