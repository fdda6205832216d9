#include "renderd/session/good_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <utility>

#include "renderd/kernel/clip.h"
#include "renderd/kernel/overlay.h"
#include "renderd/scene/frame.h"
#include "renderd/session/coarse_view.h"

namespace diaphane::render {
namespace {

/// Cells along the longest side of the visible matter.
constexpr int kCells = 32;
/// Samples per cell and axis, so that thin skin is not missed.
constexpr int kSamples = 2;
constexpr std::size_t kValueBins = 64;
/// Transmittance at which a ray counts as opaque.
constexpr double kEnd = 0.01;

constexpr int kAzimuthStep = 15;
/// Azimuths of chosen views differ by at least this. Where two neighbours are 90 degrees apart, one
/// more fits between them, so there are 5 to 8 views at steps of 15 degrees.
constexpr int kApart = 45;
constexpr std::array kElevations{-25, 5, 35};

struct Cell {
  double alpha = 0;   // opacity across the cell
  double weight = 0;  // noteworthiness
};

struct Grid {
  Double3 low;      // mm in the volume's frame
  Double3 step;     // between neighbouring cells, mm: at most `edge`
  double edge = 0;  // of a cell, mm
  std::array<int, 3> size{};
  std::vector<Cell> cells;

  std::size_t index(int x, int y, int z) const {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(size[0]) *
               (static_cast<std::size_t>(y) +
                static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(z));
  }

  /// Converts a place in cells to mm.
  Double3 place(Double3 in_cells) const {
    return low + Double3{in_cells.x * step.x, in_cells.y * step.y, in_cells.z * step.z};
  }
};

struct Sampled {
  double extinction = 0;  // mean of the cell, per mm
  double value = 0;       // of its densest sample
};

/// Samples a cell of the grid.
Sampled sample(const CoarseView& scene, const Grid& grid, std::array<int, 3> cell) {
  Sampled sampled;
  double densest = 0;
  const auto medium = medium_of<kAllFeatures>(scene, shares_at<kAllFeatures>(scene, 0.0F));
  constexpr int kAll = kSamples * kSamples * kSamples;
  for (int i = 0; i < kAll; ++i) {
    const int layer = i / (kSamples * kSamples);
    const Double3 part{(i % kSamples + 0.5) / kSamples, (i / kSamples % kSamples + 0.5) / kSamples,
                       (layer + 0.5) / kSamples};
    const Double3 at = grid.place({cell[0] + part.x, cell[1] + part.y, cell[2] + part.z});
    const Float3 place = to_float(at) * scene.inverse_spacing;
    if (!is_kept<kAllFeatures>(scene, place)) continue;
    const float value = scene.volume.at(place);
    const double extinction = medium.extinction(value, place);
    sampled.extinction += extinction / kAll;
    if (extinction <= densest) continue;
    densest = extinction;
    sampled.value = value;
  }
  return sampled;
}

/// Sets how noteworthy each cell is: its opacity times the information of its value, -log2 of the
/// share of visible cells with a similar value (Bordoloi and Shen 2005).
void weigh(Grid& grid, const std::vector<double>& values) {
  double least = 0, most = 0;
  std::size_t visible = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (grid.cells[i].alpha <= 0) continue;
    least = visible == 0 ? values[i] : std::min(least, values[i]);
    most = visible == 0 ? values[i] : std::max(most, values[i]);
    ++visible;
  }
  const auto bin = [&](double value) {
    const double part = most > least ? (value - least) / (most - least) : 0;
    return std::min(static_cast<std::size_t>(part * kValueBins), kValueBins - 1);
  };
  std::array<std::size_t, kValueBins> counts{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (grid.cells[i].alpha > 0) ++counts.at(bin(values[i]));
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    Cell& cell = grid.cells[i];
    if (cell.alpha <= 0) continue;
    // Counts one more, so that cells of the only value have some weight, too.
    const double share =
        static_cast<double>(counts.at(bin(values[i]))) / (static_cast<double>(visible) + 1);
    cell.weight = cell.alpha * -std::log2(share);
  }
}

/// Returns the box around the part of `box` that a half-space keeps.
Box kept_part(const Box& box, const HalfSpace& kept) {
  std::array<double, 3> low{box.low.x, box.low.y, box.low.z};
  std::array<double, 3> high{box.high.x, box.high.y, box.high.z};
  const std::array<double, 3> normal{kept.normal.x, kept.normal.y, kept.normal.z};
  double least = 0;  // of the normal times a place in the box
  for (std::size_t i = 0; i < 3; ++i) least += std::min(normal[i] * low[i], normal[i] * high[i]);
  const double left = kept.most - least;
  for (std::size_t i = 0; i < 3; ++i) {
    if (normal[i] > 0) high[i] = std::min(high[i], low[i] + left / normal[i]);
    if (normal[i] < 0) low[i] = std::max(low[i], high[i] + left / normal[i]);
  }
  return {to_float(Double3{low[0], low[1], low[2]}), to_float(Double3{high[0], high[1], high[2]})};
}

/// Returns the visible matter on a coarse grid in the volume's frame, or nullopt if there is none.
std::optional<Grid> grid_of(const CoarseView& scene, const volume::Header& header) {
  // Cells would be too coarse for a thin slice if they covered what the clip removes.
  Box box = scene.grid.occupied;
  for (std::uint32_t i = 0; i < scene.clip.count; ++i) box = kept_part(box, scene.clip.kept[i]);
  const Double3 spacing{header.spacing[0], header.spacing[1], header.spacing[2]};
  const Double3 low{box.low.x * spacing.x, box.low.y * spacing.y, box.low.z * spacing.z};
  const Double3 side{box.high.x * spacing.x - low.x, box.high.y * spacing.y - low.y,
                     box.high.z * spacing.z - low.z};
  const double longest = std::max({side.x, side.y, side.z});
  if (!(longest > 0) || std::min({side.x, side.y, side.z}) < 0) return std::nullopt;
  Grid grid{low, {}, longest / kCells, {}, {}};
  const std::array sides{side.x, side.y, side.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    grid.size.at(axis) =
        std::clamp(static_cast<int>(std::ceil(sides.at(axis) / grid.edge)), 1, kCells);
  }
  grid.step = {side.x / grid.size[0], side.y / grid.size[1], side.z / grid.size[2]};
  std::vector<double> values;
  for (int z = 0; z < grid.size[2]; ++z) {
    for (int y = 0; y < grid.size[1]; ++y) {
      for (int x = 0; x < grid.size[0]; ++x) {
        const Sampled sampled = sample(scene, grid, {x, y, z});
        grid.cells.push_back({1 - std::exp(-sampled.extinction * grid.edge), 0});
        values.push_back(sampled.value);
      }
    }
  }
  weigh(grid, values);
  return grid;
}

/// Adds what a ray sees of each cell: the transmittance to it times its weight.
void trace(const Grid& grid, Double3 start, Double3 along, std::vector<double>& seen) {
  // In cells. Each step is one cell long.
  double begin = 0, end = 4 * kCells;
  const std::array origin{start.x, start.y, start.z}, direction{along.x, along.y, along.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double d = direction.at(axis), o = origin.at(axis), size = grid.size.at(axis);
    if (std::abs(d) < 1e-12) {
      if (o < 0 || o >= size) return;
      continue;
    }
    begin = std::max(begin, std::min(-o / d, (size - o) / d));
    end = std::min(end, std::max(-o / d, (size - o) / d));
  }
  double clear = 1;
  for (double at = begin + 0.5; at < end && clear > kEnd; at += 1) {
    const Double3 place = start + along * at;
    const auto cell = [&](double where, std::size_t axis) {
      return std::clamp(static_cast<int>(where), 0, grid.size.at(axis) - 1);
    };
    const std::size_t i = grid.index(cell(place.x, 0), cell(place.y, 1), cell(place.z, 2));
    const Cell& one = grid.cells[i];
    if (one.alpha <= 0) continue;
    seen[i] += clear * one.weight;
    clear *= 1 - one.alpha;
  }
}

/// Returns the entropy of what is visible from afar. `towards`: unit vector to the eye, in the
/// volume's frame.
double entropy_from(const Grid& grid, Double3 towards, std::vector<double>& seen) {
  seen.assign(grid.cells.size(), 0);
  const Double3 middle{0.5 * grid.size[0], 0.5 * grid.size[1], 0.5 * grid.size[2]};
  const double radius = std::sqrt(dot(middle, middle));
  const Double3 other = std::abs(towards.z) < 0.9 ? Double3{0, 0, 1} : Double3{1, 0, 0};
  const Double3 u = normalize(cross(other, towards)), v = cross(towards, u);
  const double rays = std::ceil(radius);
  for (double j = -rays; j <= rays; ++j) {
    for (double i = -rays; i <= rays; ++i) {
      if (i * i + j * j > radius * radius) continue;
      trace(grid, middle + towards * radius + u * i + v * j, towards * -1.0, seen);
    }
  }
  double sum = 0, logs = 0;
  for (const double one : seen) {
    if (one <= 0) continue;
    sum += one;
    logs += one * std::log2(one);
  }
  return sum > 0 ? std::log2(sum) - logs / sum : 0;
}

Double3 direction_of(const GoodView& view) {
  const double degree = std::numbers::pi / 180;
  const double azimuth = view.azimuth * degree, elevation = view.elevation * degree;
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

/// Returns the best views that are kApart, by rising azimuth.
std::vector<GoodView> chosen(std::vector<GoodView> candidates) {
  std::ranges::stable_sort(candidates, std::ranges::greater(), &GoodView::entropy);
  std::vector<GoodView> views;
  for (const GoodView& one : candidates) {
    const bool alone = std::ranges::all_of(views, [&](const GoodView& other) {
      const double apart = std::abs(one.azimuth - other.azimuth);
      return std::min(apart, 360 - apart) >= kApart;
    });
    if (alone) views.push_back(one);
  }
  std::ranges::sort(views, {}, &GoodView::azimuth);
  return views;
}

/// Enlarges a box so that it encloses a place.
void enclose(Double3 place, GoodViews& box) {
  box.low = {std::min(box.low.x, place.x), std::min(box.low.y, place.y),
             std::min(box.low.z, place.z)};
  box.high = {std::max(box.high.x, place.x), std::max(box.high.y, place.y),
              std::max(box.high.z, place.z)};
}

/// Sets the box around all cells with matter.
void set_box(const Grid& grid, const WorldToFrame& frame, GoodViews& to) {
  to.low = {1e30, 1e30, 1e30};
  to.high = {-1e30, -1e30, -1e30};
  const auto [nx, ny, nz] = grid.size;
  for (int i = 0; i < nx * ny * nz; ++i) {
    if (grid.cells[static_cast<std::size_t>(i)].alpha <= 0) continue;
    const int layer = i / (nx * ny);
    for (int corner = 0; corner < 8; ++corner) {
      const Double3 at{i % nx + (corner & 1) * 1.0, i / nx % ny + (corner >> 1 & 1) * 1.0,
                       layer + (corner >> 2) * 1.0};
      const Double3 from_middle = grid.place(at) - frame.extent * 0.5;
      enclose(frame.axes[0] * from_middle.x + frame.axes[1] * from_middle.y +
                  frame.axes[2] * from_middle.z,
              to);
    }
  }
}

}  // namespace

GoodViews good_views(const CoarseVolume& coarse, const diaphane::v1::Scene& scene,
                     const CoarseSecond& second) {
  GoodViews good;
  const volume::Header& header = coarse.volume.header;
  with_coarse_view(coarse, second, scene, {64, 64}, [&](const CoarseView& view) {
    const std::optional<Grid> grid = grid_of(view, header);
    if (!grid || std::ranges::none_of(grid->cells, [](const Cell& one) { return one.alpha > 0; })) {
      return;
    }
    const WorldToFrame frame(header);
    std::vector<GoodView> candidates;
    std::vector<double> seen;
    for (int azimuth = -180; azimuth < 180; azimuth += kAzimuthStep) {
      for (const int elevation : kElevations) {
        GoodView one{static_cast<double>(azimuth), static_cast<double>(elevation), 0};
        one.entropy = entropy_from(*grid, frame.direction(direction_of(one)), seen);
        candidates.push_back(one);
      }
    }
    good.views = chosen(std::move(candidates));
    set_box(*grid, frame, good);
  });
  return good;
}

diaphane::v1::GoodViews to_proto(const GoodViews& views) {
  diaphane::v1::GoodViews out;
  for (const GoodView& view : views.views) {
    auto& to = *out.add_views();
    to.set_azimuth(view.azimuth);
    to.set_elevation(view.elevation);
    to.set_entropy(view.entropy);
  }
  if (views.views.empty()) return out;
  const auto set = [](const Double3& from, diaphane::v1::Vec3& to) {
    to.set_x(from.x);
    to.set_y(from.y);
    to.set_z(from.z);
  };
  set(views.low, *out.mutable_low());
  set(views.high, *out.mutable_high());
  return out;
}

}  // namespace diaphane::render
