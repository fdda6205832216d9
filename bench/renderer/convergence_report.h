#pragma once

#include <string>

#include "bench/renderer/convergence.h"

namespace diaphane::render::bench {

/// What a report states besides the measured curves: the setup and the parameters of its summary.
struct ReportHead {
  EngineInfo engine;
  std::string volume, scene;  ///< names for display
  unsigned devices = 1;
  std::uint32_t repeats = 0;
  double target = 0.05;  ///< the error for which times are given
  /// Minimum samples of the slope; with fewer, clipping and sparse contents bend the line.
  std::uint32_t slope_from = 32;
};

/// Returns "exact", "tracking" or "auto".
const char* word_of(Walk walk);
/// Returns "light", "scatter" or "both".
const char* word_of(Mis mis);
/// Returns "between", "at the first sample" or "prolonged".
const char* word_of(Crossing::How how);

/// Returns the title of a curve, for example "exact walk, low-discrepancy points".
std::string name_of(Method method);

std::string report_json(const ReportHead& head, const Convergence& result);
/// Returns one line per point, with a heading.
std::string report_csv(const Convergence& result);
/// Returns a report for people.
std::string report_text(const ReportHead& head, const Convergence& result);

}  // namespace diaphane::render::bench
