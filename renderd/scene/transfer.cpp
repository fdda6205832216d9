#include "renderd/scene/transfer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "renderd/kernel/tracking.h"

namespace diaphane::render {
namespace {

constexpr double kNodesWide = 4096;  // enough for the 12 bits of CT, and fits the first-level cache
constexpr double kNodesSparse = 8192;  // for wider ranges
constexpr double kNodesMost = 65536;   // for curves with close points
constexpr double kFinest = 64;         // nodes per unit of value

double opacity_of(const diaphane::v1::Channel& channel, double value) {
  const auto& points = channel.opacity();
  if (value < points[0].value() || value > points[points.size() - 1].value()) return 0;
  for (int i = 1; i < points.size(); ++i) {
    if (value <= points[i].value()) {
      const double a = points[i - 1].value(), b = points[i].value();
      const double w = (value - a) / (b - a);
      return points[i - 1].opacity() + w * (points[i].opacity() - points[i - 1].opacity());
    }
  }
  return 0;
}

double smallest_gap(const diaphane::v1::TransferFunction& function) {
  double gap = std::numeric_limits<double>::infinity();
  for (const auto& channel : function.channels()) {
    if (channel.disabled()) continue;
    for (int i = 1; i < channel.opacity_size(); ++i) {
      gap = std::min(gap, channel.opacity(i).value() - channel.opacity(i - 1).value());
    }
  }
  return gap;
}

/// Returns the nodes per unit of value, a power of two so that value * scale is exact.
double nodes_per_unit(const diaphane::v1::TransferFunction& function, double range) {
  double k = 16;
  while (k > 1 && range * k > kNodesWide) k /= 2;
  while (range * k > kNodesSparse) k /= 2;
  const double gap = smallest_gap(function);
  while (k * gap < 2 && k < kFinest && range * k * 2 <= kNodesMost) k *= 2;
  return k;
}

/// Minimum and maximum of a piecewise linear table over any range in constant time: extrema over
/// runs of 2^level nodes, two of which cover any run.
class TableExtrema {
 public:
  explicit TableExtrema(std::vector<float> table) : table_(std::move(table)) {
    levels_.emplace_back(table_.size());
    for (std::size_t i = 0; i < table_.size(); ++i) levels_[0][i] = {table_[i], table_[i]};
    for (std::size_t half = 1; 2 * half <= table_.size(); half *= 2) {
      const std::vector<CellBounds>& below = levels_.back();
      std::vector<CellBounds> level(table_.size() - 2 * half + 1);
      for (std::size_t i = 0; i < level.size(); ++i) level[i] = join(below[i], below[i + half]);
      levels_.push_back(std::move(level));
    }
  }

  /// Appends the rows of maxima described at TransferView::extinction. A run that would extend
  /// beyond the table ends with it.
  void append_maxima(std::vector<float>& rows) const {
    for (std::size_t level = 1; level < levels_.size(); ++level) {
      const std::vector<CellBounds>& runs = levels_[level];
      for (std::size_t i = 0; i < table_.size(); ++i) {
        rows.push_back(runs[std::min(i, runs.size() - 1)].majorant);
      }
    }
  }

  /// Returns the extrema over [low, high], in nodes, clamped to the table.
  CellBounds over(double low, double high) const {
    const double last = static_cast<double>(table_.size() - 1);
    low = std::clamp(low, 0.0, last);
    high = std::clamp(high, 0.0, last);
    CellBounds bounds = join(at(low), at(high));
    const auto first_node = static_cast<std::size_t>(std::ceil(low));
    const auto last_node = static_cast<std::size_t>(std::floor(high));
    if (first_node <= last_node) {
      const std::size_t count = last_node - first_node + 1;
      std::size_t level = 0;
      while ((std::size_t{2} << level) <= count) ++level;
      bounds = join(bounds, join(levels_[level][first_node],
                                 levels_[level][last_node + 1 - (std::size_t{1} << level)]));
    }
    return bounds;
  }

 private:
  static CellBounds join(CellBounds a, CellBounds b) {
    return {std::min(a.minorant, b.minorant), std::max(a.majorant, b.majorant)};
  }
  CellBounds at(double x) const {
    const auto node = std::min(static_cast<std::size_t>(x), table_.size() - 2);
    const float w = static_cast<float>(x - static_cast<double>(node));
    const float e = table_[node] + w * (table_[node + 1] - table_[node]);
    return {e, e};
  }

  std::vector<float> table_;
  std::vector<std::vector<CellBounds>> levels_;
};

void bake(const diaphane::v1::TransferFunction& function, double minimum, double k,
          PreparedTransfer& out) {
  for (std::size_t node = 0; node < out.extinction.size(); ++node) {
    const Material m = material_at(function, minimum + static_cast<double>(node) / k);
    out.extinction[node] = static_cast<float>(m.opacity * function.extinction_per_mm());
    const Float3 c = to_float(m.weighted_albedo);
    out.colour[node] = {c.x, c.y, c.z, static_cast<float>(m.weight)};
    if (!out.gloss.empty()) {
      const Float3 s = to_float(m.weighted_specular);
      out.gloss[node] = {s.x, s.y, s.z, static_cast<float>(m.weighted_gloss)};
    }
    if (!out.emission.empty()) {
      const Float3 e = to_float(m.weighted_emission);
      out.emission[node] = {e.x, e.y, e.z, static_cast<float>(m.weight)};
    }
  }
}

Double3 double_colour_of(const diaphane::v1::Rgb& c) { return {c.r(), c.g(), c.b()}; }

/// Returns whether an enabled channel has some of the colour that `colour` returns.
template <typename Colour>
bool has_some(const diaphane::v1::TransferFunction& function, const Colour& colour) {
  return std::any_of(function.channels().begin(), function.channels().end(),
                     [&](const diaphane::v1::Channel& channel) {
                       const Double3 c = double_colour_of(colour(channel));
                       return !channel.disabled() && (c.x > 0 || c.y > 0 || c.z > 0);
                     });
}

/// Returns the distance, in nodes, by which fp32 rounding can put an interpolated value outside the
/// range of its voxels.
double rounding_margin(const ValueGrid& grid, double k) {
  const int largest = std::max(std::abs(static_cast<int>(grid.whole.minimum)),
                               std::abs(static_cast<int>(grid.whole.maximum)));
  return largest * k * 0x1p-21 + 0x1p-10;
}

void bound_cells(const ValueGrid& grid, const TableExtrema& extrema, PreparedTransfer& out) {
  // Interpolation in the table may leave the range of its nodes by rounding.
  constexpr float kUp = 1 + 1e-6f, kDown = 1 - 1e-6f;
  const double k = out.scale, margin = out.margin;
  for (std::size_t cell = 0; cell < grid.ranges.size(); ++cell) {
    const ValueRange range = grid.ranges[cell];
    const CellBounds b = extrema.over((range.minimum - grid.whole.minimum) * k - margin,
                                      (range.maximum - grid.whole.minimum) * k + margin);
    out.bounds[cell] = {b.minorant * kDown, b.majorant * kUp};
  }
}

}  // namespace

bool is_steep(const std::vector<CellBounds>& bounds, Float3 spacing) {
  const float diagonal = kCellSize * length(spacing);
  return std::any_of(bounds.begin(), bounds.end(), [diagonal](CellBounds b) {
    return (b.majorant - b.minorant) * diagonal > 3 * kDeepCell;
  });
}

Box occupied_box(const std::vector<CellBounds>& bounds, Int3 cells, Int3 size) {
  Int3 low = cells, high{-1, -1, -1};
  std::size_t cell = 0;
  for (std::int32_t z = 0; z < cells.z; ++z) {
    for (std::int32_t y = 0; y < cells.y; ++y) {
      for (std::int32_t x = 0; x < cells.x; ++x, ++cell) {
        if (!(bounds[cell].majorant > 0)) continue;
        low = {std::min(low.x, x), std::min(low.y, y), std::min(low.z, z)};
        high = {std::max(high.x, x), std::max(high.y, y), std::max(high.z, z)};
      }
    }
  }
  if (high.x < 0) return {{0, 0, 0}, {0, 0, 0}};
  const auto edge = [](std::int32_t c, std::int32_t n) {
    return static_cast<float>(std::min((c + 1) * kCellSize, n));
  };
  return {{static_cast<float>(low.x * kCellSize), static_cast<float>(low.y * kCellSize),
           static_cast<float>(low.z * kCellSize)},
          {edge(high.x, size.x), edge(high.y, size.y), edge(high.z, size.z)}};
}

Material material_at(const diaphane::v1::TransferFunction& function, double value) {
  Material m;
  for (const auto& channel : function.channels()) {
    if (channel.disabled()) continue;
    const double opacity = opacity_of(channel, value);
    m.opacity = std::max(m.opacity, opacity);
    m.weighted_albedo += double_colour_of(channel.diffuse()) * opacity;
    m.weight += opacity;
    m.weighted_specular += double_colour_of(channel.specular()) * opacity;
    m.weighted_gloss += channel.gloss() * opacity;
    m.weighted_emission += double_colour_of(channel.emission()) * opacity;
  }
  return m;
}

PreparedTransfer prepare_transfer(const diaphane::v1::TransferFunction& function,
                                  const ValueGrid& grid, Int3 size, Float3 spacing) {
  const double minimum = grid.whole.minimum;
  const double range = grid.whole.maximum - minimum;
  const double k = nodes_per_unit(function, range);
  const auto count = static_cast<std::size_t>(std::ceil(range * k)) + 1;
  PreparedTransfer out;
  out.extinction.resize(std::max<std::size_t>(count, 2));
  out.count = static_cast<std::int32_t>(out.extinction.size());
  out.colour.resize(out.extinction.size());
  if (has_some(function, [](const auto& channel) { return channel.specular(); })) {
    out.gloss.resize(out.extinction.size());
  }
  if (has_some(function, [](const auto& channel) { return channel.emission(); })) {
    out.emission.resize(out.extinction.size());
  }
  out.scale = static_cast<float>(k);
  out.offset = static_cast<float>(-minimum * k);
  out.cells = grid.cells;
  out.bounds.resize(grid.ranges.size());
  bake(function, minimum, k, out);
  out.densest = *std::max_element(out.extinction.begin(), out.extinction.end());
  out.margin = static_cast<float>(rounding_margin(grid, k));
  out.exact = make_exact_tables(out.extinction.data(), out.count, k, grid);
  if (grid.ranges.empty()) return out;
  const TableExtrema extrema(out.extinction);
  bound_cells(grid, extrema, out);
  out.steep = is_steep(out.bounds, spacing);
  extrema.append_maxima(out.extinction);
  out.occupied = occupied_box(out.bounds, out.cells, size);
  return out;
}

std::shared_ptr<const PreparedTransfer> TransferCache::get(
    const diaphane::v1::TransferFunction& function, const ValueGrid& grid, Int3 size,
    Float3 spacing) {
  // Enough for two sessions with different looks.
  constexpr std::size_t kBakedKept = 2;
  const std::string key = function.SerializeAsString();
  {
    const std::lock_guard lock(mutex_);
    for (const Baked& baked : baked_) {
      if (baked.function == key) return baked.transfer;
    }
  }
  auto transfer =
      std::make_shared<const PreparedTransfer>(prepare_transfer(function, grid, size, spacing));
  const std::lock_guard lock(mutex_);
  if (baked_.size() >= kBakedKept) baked_.erase(baked_.begin());
  baked_.push_back({key, transfer});
  return transfer;
}

}  // namespace diaphane::render
