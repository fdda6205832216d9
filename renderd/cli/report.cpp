#include "renderd/cli/report.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace diaphane::render::cli {

std::string report_json(const Options& options, const Outcome& outcome) {
  const double pixels = double{1} * options.canvas.width * options.canvas.height;
  const Progress& progress = outcome.progress;
  nlohmann::ordered_json json{
      {"samples", progress.samples},
      {"milliseconds", progress.seconds * 1e3},
      {"estimated_error", nullptr},
      {"dropped_samples", outcome.dropped_samples},
      {"samples_per_second", nullptr},
      {"engine", outcome.engine.engine},
      {"device", outcome.engine.device},
      {"features", outcome.features},
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
