#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "bench/renderer/stability.h"
#include "renderd/math/vector.h"
#include "tests/support/renderd/test_scenes.h"

// Helpers of the stability table's cases.

namespace diaphane::render::bench {

/// A case of the table, which fills a row.
struct StabilityCase {
  std::string about;
  std::function<void(Engine&, const StabilityOptions&, StabilityRow&)> measure;
};

std::vector<StabilityCase> medium_cases();
std::vector<StabilityCase> ray_cases();
std::vector<StabilityCase> light_cases();
std::vector<StabilityCase> run_cases();
std::vector<StabilityCase> input_cases();

/// More standard deviations than chance gives in some hundred comparisons (7e-6 each, two-sided).
inline constexpr double kMostSigmas = 4.5;
/// Rounding of fp32 along a ray of some hundred steps.
inline constexpr double kRounding = 2e-5;

/// Statistics of a picture whose pixels all have the same expectation.
struct ImageStats {
  double mean = 0;       ///< over pixels and colours
  double deviation = 0;  ///< standard deviation of `mean`, from the spread of the pixels
  double smallest = 0, largest = 0;
  std::vector<float> pixels;
  std::string refused;  ///< why there is no picture
};
/// Renders a picture, and adds its samples and non-finite values to the row.
ImageStats image_stats(Engine& engine, const volume::Volume& volume,
                       const diaphane::v1::Scene& scene, Canvas canvas, std::uint32_t samples,
                       StabilityRow& row);

/// Compares with a known value in standard deviations and keeps the largest deviation. A difference
/// within rounding counts as 0.
void compare(const ImageStats& stats, double expected, StabilityRow& row);
/// Compares two estimates of the same value.
void compare(const ImageStats& a, const ImageStats& b, StabilityRow& row);
/// Compares a relative or absolute deviation with a limit.
void note_deviation(double deviation, double limit, const std::string& unit, StabilityRow& row);

/// Returns a scene with a thin parallel beam that measures transmittance: no light, and white
/// behind, so that the mean of a pixel is the transmittance from `from` to `to` (world, mm).
/// `width` in mm.
diaphane::v1::Scene beam(Double3 from, Double3 to, double width);
void set_medium(diaphane::v1::Scene& scene,
                std::initializer_list<std::pair<double, double>> opacity, double extinction);

/// Returns the length in mm of the ray from `from` towards `to` (world) inside a volume's box.
/// Computed with slabs in double precision, independently of the renderer's code.
double length_inside(const volume::Header& header, Double3 from, Double3 to);

inline Double3 along(int axis, double x) {
  return {axis == 0 ? x : 0.0, axis == 1 ? x : 0.0, axis == 2 ? x : 0.0};
}

}  // namespace diaphane::render::bench
