#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "renderd/engine/frame_renderer.h"

// The stiff and extreme cases (design: renderer, "Stiff and extreme cases") on one engine. Each is
// rendered through the engine's public interface and compared with an analytic value, or with an
// independent evaluation in double precision.

namespace diaphane::render::bench {

/// One line of the table.
struct StabilityRow {
  std::string about;
  double samples = 0;            ///< rays through all pixels, over all pictures of the case
  std::uint64_t non_finite = 0;  ///< non-finite values in pictures, and dropped samples
  double deviation = 0;          ///< the largest of the case
  std::string unit;  ///< unit of the deviation: "sigma", "relative", "absolute", "ms", "fields"
  double limit = 0;  ///< limit of the deviation
  bool passed = false;
  std::string note;
};

struct StabilityOptions {
  bool quick = false;                             ///< a tenth of the samples
  std::string only;                               ///< runs only cases whose name contains this
  std::function<void(const StabilityRow&)> each;  ///< called for each row as it is finished
};

std::vector<StabilityRow> measure_stability(Engine& engine, const StabilityOptions& options);

std::string stability_text(const StabilityRow& row, const std::string& engine);
std::string stability_json(const std::vector<StabilityRow>& rows, const EngineInfo& engine);
std::string stability_csv(const std::vector<StabilityRow>& rows, const std::string& engine);

}  // namespace diaphane::render::bench
