#include "renderd/cli/report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "renderd/kernel/features.h"

namespace diaphane::render::cli {

namespace {

std::vector<std::string> left_out(const std::vector<std::string>& features) {
  std::vector<std::string> names;
  for (const char* name : kFeatureNames) {
    if (std::find(features.begin(), features.end(), name) == features.end()) {
      names.emplace_back(name);
    }
  }
  return names;
}

nlohmann::ordered_json kernel_json(const KernelReport& kernel) {
  nlohmann::ordered_json json{
      {"variant", name_of(kernel.origin)},
      {"compiled_in", kernel.compiled_in},
      {"left_out", kernel.left_out},
      {"compile_milliseconds", kernel.compile_milliseconds},
      {"from_cache", kernel.from_cache},
      {"registers", nullptr},
      {"local_bytes", nullptr},
      {"empty_cells", kernel.empty_cells},
      {"volume_bytes", kernel.volume_bytes},
      {"acceleration_bytes", kernel.acceleration_bytes},
      {"shared_bytes", kernel.shared_bytes},
      {"film_bytes", kernel.film_bytes},
  };
  if (kernel.registers) json["registers"] = *kernel.registers;
  if (kernel.local_bytes) json["local_bytes"] = *kernel.local_bytes;
  if (kernel.denoise_milliseconds) json["denoise_milliseconds"] = *kernel.denoise_milliseconds;
  if (!kernel.note.empty()) json["note"] = kernel.note;
  return json;
}

nlohmann::ordered_json curve_json(const ErrorCurve& curve) {
  auto points = nlohmann::ordered_json::array();
  for (const ErrorPoint& point : curve.points()) {
    points.push_back({{"samples", point.samples},
                      {"milliseconds", point.seconds * 1e3},
                      {"error", point.error}});
  }
  return points;
}

}  // namespace

std::string report_json(const Options& options, const Outcome& outcome) {
  const double pixels = double{1} * options.canvas.width * options.canvas.height;
  const Progress& progress = outcome.progress;
  nlohmann::ordered_json json{
      {"samples", progress.samples},
      {"milliseconds", progress.seconds * 1e3},
      {"estimated_error", nullptr},
      {"automatic_exposure", progress.stops},
      {"error_curve", curve_json(outcome.curve)},
      {"stopped_by", name_of(outcome.stopped_by)},
      {"dropped_samples", outcome.dropped_samples},
      {"samples_per_second", nullptr},
      {"engine", outcome.engine.engine},
      {"device", outcome.engine.device},
      {"features", outcome.features},
      {"left_out", left_out(outcome.features)},
      {"kernel", kernel_json(outcome.kernel)},
      {"denoised", outcome.denoised},
      {"width", options.canvas.width},
      {"height", options.canvas.height},
      {"seed", options.seed},
  };
  if (std::isfinite(progress.error)) json["estimated_error"] = progress.error;
  if (progress.seconds > 0) {
    json["samples_per_second"] = pixels * static_cast<double>(progress.samples) / progress.seconds;
  }
  return json.dump(2) + "\n";
}

}  // namespace diaphane::render::cli
