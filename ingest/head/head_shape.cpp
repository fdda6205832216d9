#include <algorithm>
#include <cmath>
#include <numbers>

#include "ingest/head/signs.h"

namespace diaphane::ingest {
namespace {

// Width and depth of a head in mm, with scalp and hair, from a small child to a large man.
constexpr double kLeastAcross = 105, kMostAcross = 190;
constexpr double kLeastDeep = 130, kMostDeep = 240;
constexpr double kLeastRatio = 0.95, kMostRatio = 1.65;  // ratio of depth to width
// Area of a cross-section as a share of the ellipse with the same axes.
constexpr double kLeastFilled = 0.8, kMostFilled = 1.12;
constexpr int kLeastHeadLevels = 15;  // consecutive levels: 45 mm
constexpr double kDomeBelow = 0.55;   // share of the largest area, near the top
constexpr int kDomeLevels = 20;       // at most this many levels above the last one that fits

/// Returns a threshold between air and matter, which is brighter: the darkest value plus half of
/// the distance from there to Otsu's threshold. Returns 0 if there are too few cells.
float between_air_and_matter(const Coarse& coarse) {
  std::vector<float> values;
  for (const float v : coarse.mean) {
    if (v != Coarse::kNothing) values.push_back(v);
  }
  if (values.size() < 100) return 0;
  // Fat, vessels and flow are the brightest and must not raise the threshold.
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 98 / 100);
  std::nth_element(values.begin(), place, values.end());
  const float high = *place, low = *std::min_element(values.begin(), values.end());
  if (!(high > low)) return high;
  constexpr int kBins = 256;
  std::array<double, kBins> count{};
  for (const float v : values) {
    const float part = std::clamp((v - low) / (high - low), 0.0F, 1.0F);
    count[static_cast<std::size_t>(part * (kBins - 1))] += 1;
  }
  double total = 0, sum = 0;
  for (int i = 0; i < kBins; ++i) total += count[i], sum += i * count[i];
  double below = 0, sum_below = 0, best = -1, threshold = 0;
  for (int i = 0; i < kBins - 1; ++i) {
    below += count[i];
    sum_below += i * count[i];
    if (below == 0 || below == total) continue;
    const double apart = sum_below / below - (sum - sum_below) / (total - below);
    const double between = below * (total - below) * apart * apart;
    if (between > best) best = between, threshold = i;
  }
  // Half of the threshold, so that dark matter at the surface (bone, fluid in T1) counts as matter.
  return low + (high - low) * static_cast<float>(threshold / (kBins - 1)) * 0.5F;
}

struct BodyLevel {
  double area = 0;  // mm^2
  double across = 0, deep = 0, middle_x = 0, front = 0, back = 0;
  bool fits = false;
};

BodyLevel look_at(const Coarse& coarse, int z, float threshold) {
  const int width = coarse.size[0], height = coarse.size[1];
  Mask air(coarse.cells_of_level());
  const std::size_t first = coarse.at(0, 0, z);
  for (std::size_t i = 0; i < air.size(); ++i) air[i] = coarse.mean[first + i] < threshold;
  const Mask outside = reached_from_border(air, width, height);
  Mask body(air.size());
  for (std::size_t i = 0; i < body.size(); ++i) body[i] = !outside[i];
  const std::size_t cells = keep_largest(body, width, height);
  BodyLevel level;
  level.area = static_cast<double>(cells) * Coarse::kCellMm * Coarse::kCellMm;
  if (cells == 0) return level;
  int low_x = width, high_x = -1, low_y = height, high_y = -1;
  for (int cell = 0; cell < width * height; ++cell) {
    if (!body[static_cast<std::size_t>(cell)]) continue;
    low_x = std::min(low_x, cell % width), high_x = std::max(high_x, cell % width);
    low_y = std::min(low_y, cell / width), high_y = std::max(high_y, cell / width);
  }
  level.across = (high_x - low_x + 1) * Coarse::kCellMm;
  level.deep = (high_y - low_y + 1) * Coarse::kCellMm;
  level.middle_x = (coarse.place(low_x, 0, 0)[0] + coarse.place(high_x, 0, 0)[0]) / 2;
  level.front = coarse.place(0, low_y, 0)[1] - Coarse::kCellMm / 2;
  level.back = level.front + level.deep;
  const double filled = level.area / (std::numbers::pi / 4 * level.across * level.deep);
  const double ratio = level.deep / level.across;
  level.fits = level.across >= kLeastAcross && level.across <= kMostAcross &&
               level.deep >= kLeastDeep && level.deep <= kMostDeep && ratio >= kLeastRatio &&
               ratio <= kMostRatio && filled >= kLeastFilled && filled <= kMostFilled;
  return level;
}

}  // namespace

std::optional<Brain> find_head_shape(const Coarse& coarse) {
  const float threshold = between_air_and_matter(coarse);
  std::vector<BodyLevel> levels;
  for (int z = 0; z < coarse.size[2]; ++z) levels.push_back(look_at(coarse, z, threshold));

  int top = -1, run = 0;  // the last level of the topmost run that is long enough
  for (int z = 0; z < coarse.size[2]; ++z) {
    run = levels[static_cast<std::size_t>(z)].fits ? run + 1 : 0;
    if (run >= kLeastHeadLevels) top = z;
  }
  if (top < 0) return std::nullopt;
  double largest = 0;
  for (int z = top; z > top - kLeastHeadLevels; --z) {
    largest = std::max(largest, levels[static_cast<std::size_t>(z)].area);
  }
  int vertex = -1;
  for (int z = top + 1; z < coarse.size[2] && z <= top + kDomeLevels; ++z) {
    const BodyLevel& level = levels[static_cast<std::size_t>(z)];
    if (level.area > levels[static_cast<std::size_t>(z) - 1].area * 1.1) return std::nullopt;
    if (level.area > 0) vertex = z;
    if (level.area < kDomeBelow * largest) {
      // The shape narrows to a dome, whether or not its very top is in the image.
      while (vertex + 1 < coarse.size[2] && levels[static_cast<std::size_t>(vertex) + 1].area > 0 &&
             vertex < top + kDomeLevels) {
        ++vertex;
      }
      break;
    }
    if (z + 1 == coarse.size[2] || z == top + kDomeLevels) return std::nullopt;
  }
  if (vertex < 0) return std::nullopt;

  // Estimates the brain as an ellipsoid under the vertex, inside scalp and skull at the widest
  // level.
  const BodyLevel* widest = &levels[static_cast<std::size_t>(top)];
  for (int z = top; z > top - kLeastHeadLevels; --z) {
    const BodyLevel& level = levels[static_cast<std::size_t>(z)];
    if (level.area > widest->area) widest = &level;
  }
  constexpr double kShell = 13;  // mm: scalp and skull
  constexpr double kHalfHigh = 62;
  const double crown = coarse.place(0, 0, vertex)[2] + Coarse::kCellMm / 2;
  const std::array<double, 3> half{widest->across / 2 - kShell,
                                   std::min(widest->deep / 2 - kShell, 92.0), kHalfHigh};
  const std::array<double, 3> middle{widest->middle_x, widest->back - kShell - half[1],
                                     crown - kShell - kHalfHigh};
  Brain brain;
  constexpr int kSteps = 24;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < 2 * kSteps; ++j) {
      const double polar = std::numbers::pi * (i + 0.5) / kSteps;
      const double turn = std::numbers::pi * j / kSteps;
      brain.push_back({middle[0] + half[0] * std::sin(polar) * std::cos(turn),
                       middle[1] + half[1] * std::sin(polar) * std::sin(turn),
                       middle[2] + half[2] * std::cos(polar)});
    }
  }
  return brain;
}

}  // namespace diaphane::ingest
