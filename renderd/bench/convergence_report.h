#pragma once

#include <string>

#include "renderd/bench/convergence.h"

namespace diaphane::render::bench {

/// What the tables say beside the figures.
struct ReportHead {
  EngineInfo engine;
  std::string volume, scene;  ///< names for the reader
  unsigned devices = 1;
  std::uint32_t repeats = 0;
  double target = 0.05;           ///< the error to which time is given
  std::uint32_t slope_from = 32;  ///< samples: below, clipping and sparse contents bend the line
};

/// "exact", "tracking", "auto".
const char* word_of(Walk walk);
/// "light", "scatter", "both".
const char* word_of(Mis mis);
/// "between", "at the first sample", "prolonged".
const char* word_of(Crossing::How how);

/// "exact walk, low-discrepancy points": what a curve is called.
std::string name_of(Method method);

std::string report_json(const ReportHead& head, const Convergence& result);
/// One line a point, with a heading.
std::string report_csv(const Convergence& result);
/// For people.
std::string report_text(const ReportHead& head, const Convergence& result);

}  // namespace diaphane::render::bench
