#include "bench/schedule/device_model.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/renderer/text.h"
#include "bench/schedule/scores.h"
#include "common/try.h"

namespace diaphane::render::bench {
namespace {

double pixels(Canvas canvas) { return double(canvas.width) * double(canvas.height); }

/// Returns the costs that `schedule --real --costs-out` measured with the exact walk.
DeviceModel h200() {
  DeviceModel model;
  model.name = "h200";
  model.parallel = 132 * 2048;
  model.queues = true;
  model.quantum_seconds = 222e-6;
  model.scene_seconds = 48e-6;
  model.picture_seconds = 116e-6;
  model.picture_seconds_per_pixel = 0.90e-9;
  model.look_seconds = 0.3e-6;
  model.scenes = {{"cranium", {2.36e-9, 0.046}},
                  {"surface", {3.19e-9, 0.033}},
                  {"light-many", {2.55e-9, 0.140}}};
  return model;
}

DeviceModel two_cores() {
  DeviceModel model;
  model.name = "cpu2";
  model.parallel = 2 * 8 * 256;
  model.quantum_seconds = 20e-6;
  model.scene_seconds = 300e-6;
  model.picture_seconds = 300e-6;
  model.picture_seconds_per_pixel = 30e-9;
  model.look_seconds = 0.3e-6;
  const double cranium = 66.5e-3 / (512 * 512);
  model.scenes = {{"cranium", {cranium, 0.30}},
                  {"surface", {1.2 * cranium, 0.35}},
                  {"light-many", {1.6 * cranium, 0.45}}};
  return model;
}

}  // namespace

SceneCost DeviceModel::scene(const std::string& scene_name) const {
  const auto found = scenes.find(scene_name);
  return found != scenes.end() ? found->second : scenes.begin()->second;
}

double DeviceModel::alone(const std::string& scene_name, Canvas canvas,
                          std::uint32_t samples) const {
  const double work = pixels(canvas) * samples;
  const double fill = parallel > 0 ? std::min(1.0, work / parallel) : 1;
  return work * scene(scene_name).seconds_per_pixel / fill;
}

double DeviceModel::picture(Canvas canvas) const {
  return picture_seconds + picture_seconds_per_pixel * pixels(canvas);
}

double DeviceModel::to_good(const std::string& scene_name, Canvas canvas) const {
  const double samples = std::ceil(std::pow(scene(scene_name).noise / kGoodError, 2));
  return scene_seconds + quantum_seconds + picture(canvas) +
         alone(scene_name, canvas, static_cast<std::uint32_t>(std::max(samples, 2.0)));
}

Result<DeviceModel> device_model(const std::string& name) {
  if (name == "h200") return h200();
  if (name == "cpu2") return two_cores();
  const auto text = read_text(name, "--costs");
  DIAPHANE_TRY(text);
  try {
    const auto json = nlohmann::json::parse(*text);
    DeviceModel model;
    model.name = json.at("name");
    model.parallel = json.at("parallel");
    model.queues = json.at("queues");
    model.quantum_seconds = json.at("quantum_seconds");
    model.scene_seconds = json.at("scene_seconds");
    model.picture_seconds = json.at("picture_seconds");
    model.picture_seconds_per_pixel = json.at("picture_seconds_per_pixel");
    model.look_seconds = json.at("look_seconds");
    for (const auto& [scene, cost] : json.at("scenes").items()) {
      model.scenes[scene] = {cost.at("seconds_per_pixel"), cost.at("noise")};
    }
    if (model.scenes.empty()) return fail(ErrorCode::kInvalid, "no scene in it", "--costs");
    return model;
  } catch (const nlohmann::json::exception& error) {
    return fail(ErrorCode::kInvalid, std::string("no costs: ") + error.what(), "--costs");
  }
}

std::string device_model_json(const DeviceModel& model) {
  nlohmann::ordered_json json{{"name", model.name},
                              {"parallel", model.parallel},
                              {"queues", model.queues},
                              {"quantum_seconds", model.quantum_seconds},
                              {"scene_seconds", model.scene_seconds},
                              {"picture_seconds", model.picture_seconds},
                              {"picture_seconds_per_pixel", model.picture_seconds_per_pixel},
                              {"look_seconds", model.look_seconds},
                              {"scenes", nlohmann::json::object()}};
  for (const auto& [scene, cost] : model.scenes) {
    json["scenes"][scene] = {{"seconds_per_pixel", cost.seconds_per_pixel}, {"noise", cost.noise}};
  }
  return json.dump(1) + "\n";
}

}  // namespace diaphane::render::bench
