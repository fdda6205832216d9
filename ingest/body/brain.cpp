#include "ingest/body/brain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "ingest/body/values.h"

namespace diaphane::ingest {
namespace {

using volume::Label;
using Index = std::array<std::int64_t, 3>;

struct Vec {
  double x = 0, y = 0, z = 0;
};
Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec operator*(Vec a, double s) { return {a.x * s, a.y * s, a.z * s}; }
double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec cross(Vec a, Vec b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double length(Vec a) { return std::sqrt(dot(a, a)); }

/// A brain reaches at most this far below the top of the head, mm.
constexpr double kHeight = 165;
/// Volumes of a human brain with the fluid around it, from a newborn's to the largest, ml.
constexpr double kSmallest = 300, kLargest = 2300;
/// No MR of a head is finer, mm. Drawing the surface takes a time that grows with the inverse
/// square of the finest spacing.
constexpr double kFinest = 0.05;

/// A volume whose places are mm along its own axes from the centre of voxel (0, 0, 0).
class Scan {
 public:
  Scan(const volume::Volume& volume, const volume::Labels& labels)
      : voxels_(volume.voxels), labels_(labels.voxels), spacing_(volume.header.spacing) {
    for (std::size_t a = 0; a < 3; ++a) size_[a] = volume.header.size[a];
    const auto& d = volume.header.direction;
    up_ = {d[6], d[7], d[8]};
  }

  /// Returns the value of the nearest voxel, or `beyond` outside of the volume.
  double at(Vec place, double beyond) const {
    const Index i = nearest(place);
    return contains(i) ? voxels_[offset(i)] : beyond;
  }
  Index nearest(Vec p) const {
    return {std::llround(p.x / spacing_[0]), std::llround(p.y / spacing_[1]),
            std::llround(p.z / spacing_[2])};
  }
  bool contains(const Index& i) const {
    return i[0] >= 0 && i[1] >= 0 && i[2] >= 0 && i[0] < size_[0] && i[1] < size_[1] &&
           i[2] < size_[2];
  }
  std::size_t offset(const Index& i) const {
    return static_cast<std::size_t>(i[0] + size_[0] * (i[1] + size_[1] * i[2]));
  }
  Vec place(const Index& i) const {
    return {static_cast<double>(i[0]) * spacing_[0], static_cast<double>(i[1]) * spacing_[1],
            static_cast<double>(i[2]) * spacing_[2]};
  }
  double height(Vec place) const { return dot(place, up_); }
  double voxel_mm3() const { return spacing_[0] * spacing_[1] * spacing_[2]; }
  double least_spacing() const { return *std::min_element(spacing_.begin(), spacing_.end()); }
  const Index& size() const { return size_; }
  bool is_body(std::size_t voxel) const {
    return labels_[voxel] == static_cast<std::uint8_t>(Label::kBody);
  }
  std::int16_t value(std::size_t voxel) const { return voxels_[voxel]; }

  /// Calls `each(index, voxel)` for every voxel of the body.
  template <typename Each>
  void for_body(Each each) const {
    std::size_t voxel = 0;
    for (std::int64_t z = 0; z < size_[2]; ++z) {
      for (std::int64_t y = 0; y < size_[1]; ++y) {
        for (std::int64_t x = 0; x < size_[0]; ++x, ++voxel) {
          if (is_body(voxel)) each(Index{x, y, z}, voxel);
        }
      }
    }
  }

 private:
  const std::vector<std::int16_t>& voxels_;
  const std::vector<std::uint8_t>& labels_;
  const std::array<double, 3> spacing_;
  Index size_{};
  Vec up_;
};

/// A histogram of 16-bit values.
class Values {
 public:
  void add(std::int16_t value) {
    ++counts_[static_cast<std::size_t>(value + 32768)];
    ++total_;
  }
  bool empty() const { return total_ == 0; }
  double quantile(double share) const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      sum += counts_[i];
      if (static_cast<double>(sum) >= share * static_cast<double>(total_)) {
        return static_cast<double>(i) - 32768;
      }
    }
    return 32767;
  }

 private:
  std::vector<std::uint64_t> counts_ = std::vector<std::uint64_t>(65536);
  std::uint64_t total_ = 0;
};

/// Facts about the head from which the balloon starts, with the names of the paper.
struct Start {
  double t2 = 0, t98 = 0;  ///< quantiles of 2% and 98% of the head's values
  double t = 0;            ///< threshold between air and matter
  double tm = 0;           ///< median value around the middle
  Vec middle;
  double radius = 0;  ///< of a ball with the volume of the head, mm
};

/// Returns the height of the top of the head: the highest level that shows 8 cm2 of matter.
std::optional<double> top_of(const Scan& scan, double threshold) {
  constexpr double kLevel = 2, kArea = 800;
  const double reach = length(scan.place(scan.size()));  // no place is higher or lower
  const auto lowest = std::llround(-reach / kLevel);
  std::vector<double> area(static_cast<std::size_t>(1 - 2 * lowest));
  scan.for_body([&](const Index& i, std::size_t voxel) {
    if (scan.value(voxel) <= threshold) return;
    const auto level = std::llround(scan.height(scan.place(i)) / kLevel) - lowest;
    area[static_cast<std::size_t>(level)] += scan.voxel_mm3() / kLevel;
  });
  for (std::size_t level = area.size(); level-- > 0;) {
    if (area[level] >= kArea) return static_cast<double>(lowest + std::int64_t(level)) * kLevel;
  }
  return std::nullopt;
}

std::optional<Start> start_of(const Scan& scan) {
  Values values;
  scan.for_body([&](const Index&, std::size_t voxel) { values.add(scan.value(voxel)); });
  if (values.empty()) return std::nullopt;
  Start start;
  start.t2 = values.quantile(0.02);
  start.t98 = values.quantile(0.98);
  start.t = start.t2 + 0.1 * (start.t98 - start.t2);
  const auto top = top_of(scan, start.t);
  if (!top || start.t98 <= start.t2) return std::nullopt;
  double weight = 0, matter = 0;
  Vec sum;
  const auto counts = [&](const Index& i, std::size_t voxel) {
    return scan.value(voxel) > start.t && scan.height(scan.place(i)) >= *top - kHeight;
  };
  scan.for_body([&](const Index& i, std::size_t voxel) {
    if (!counts(i, voxel)) return;
    const double w = std::min<double>(scan.value(voxel), start.t98) - start.t2;
    weight += w;
    matter += scan.voxel_mm3();
    sum = sum + scan.place(i) * w;
  });
  start.middle = sum * (1 / weight);
  start.radius = std::cbrt(3 * matter / (4 * std::numbers::pi));
  Values inner;
  scan.for_body([&](const Index& i, std::size_t voxel) {
    const double value = scan.value(voxel);
    if (counts(i, voxel) && value < start.t98 &&
        length(scan.place(i) - start.middle) < start.radius) {
      inner.add(scan.value(voxel));
    }
  });
  if (inner.empty()) return std::nullopt;
  start.tm = inner.quantile(0.5);
  return start;
}

struct Mesh {
  std::vector<Vec> points;
  std::vector<std::array<std::size_t, 3>> triangles;  ///< counter-clockwise from outside
};

/// Divides each triangle into four. New points are in the middle of edges.
Mesh divided(const Mesh& mesh) {
  Mesh finer{mesh.points, {}};
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> middles;
  const auto middle = [&](std::size_t a, std::size_t b) {
    const auto [found, is_new] = middles.try_emplace(std::minmax(a, b), finer.points.size());
    if (is_new) finer.points.push_back((mesh.points[a] + mesh.points[b]) * 0.5);
    return found->second;
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::size_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    finer.triangles.insert(finer.triangles.end(),
                           {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  return finer;
}

Mesh sphere(Vec middle, double radius, int divisions) {
  const double t = std::numbers::phi;
  Mesh mesh{{{-1, t, 0},
             {1, t, 0},
             {-1, -t, 0},
             {1, -t, 0},
             {0, -1, t},
             {0, 1, t},
             {0, -1, -t},
             {0, 1, -t},
             {t, 0, -1},
             {t, 0, 1},
             {-t, 0, -1},
             {-t, 0, 1}},
            {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
             {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
             {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
  for (int i = 0; i < divisions; ++i) mesh = divided(mesh);
  for (Vec& point : mesh.points) point = middle + point * (radius / length(point));
  return mesh;
}

std::vector<std::vector<std::size_t>> neighbours_of(const Mesh& mesh) {
  std::vector<std::vector<std::size_t>> near(mesh.points.size());
  for (const auto& corners : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) near[corners[i]].push_back(corners[(i + 1) % 3]);
  }
  return near;  // the surface is closed, so each edge is met once in each direction
}

std::vector<Vec> normals_of(const Mesh& mesh) {
  std::vector<Vec> normals(mesh.points.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec n = cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a]);
    for (const std::size_t corner : {a, b, c}) normals[corner] = normals[corner] + n;
  }
  for (Vec& normal : normals) normal = normal * (1 / std::max(length(normal), 1e-9));
  return normals;
}

constexpr double kDeep = 20;  ///< how far inwards the balloon looks for dark values, mm

/// Returns how strongly a point is pushed out (positive) or pulled in, as f3 of the paper.
double push(const Scan& scan, const Start& start, Vec point, Vec normal) {
  constexpr double kFraction = 0.5;  // fractional threshold between fluid and brain
  double darkest = start.tm, brightest = start.t;
  for (double depth = 0; depth < kDeep; depth += 1) {
    const double value = scan.at(point - normal * depth, start.t2);
    darkest = std::min(darkest, value);
    if (depth < kDeep / 2) brightest = std::max(brightest, value);
  }
  darkest = std::max(darkest, start.t2);
  brightest = std::min(brightest, start.tm);
  const double threshold = start.t2 + kFraction * (brightest - start.t2);
  return 2 * (darkest - threshold) / std::max(brightest - start.t2, 1e-3);
}

/// Moves all points a number of times. Each is drawn to the middle of its neighbours, less where
/// the surface is flatter than a brain's folds, and pushed until it reaches dark fluid.
void blow_up(const Scan& scan, const Start& start, Mesh& mesh, int times) {
  constexpr double kSharpest = 3.33, kFlattest = 10;  // radii of curvature, mm
  constexpr double kMiddle = (1 / kSharpest + 1 / kFlattest) / 2;
  constexpr double kSlope = 6 / (1 / kSharpest - 1 / kFlattest);
  const auto near = neighbours_of(mesh);
  std::vector<Vec> next(mesh.points.size()), means(mesh.points.size());
  for (int time = 0; time < times; ++time) {
    double edges = 0, edge_count = 0;
    for (std::size_t i = 0; i < near.size(); ++i) {
      Vec sum;
      for (const std::size_t other : near[i]) {
        sum = sum + mesh.points[other];
        edges += length(mesh.points[other] - mesh.points[i]);
      }
      edge_count += static_cast<double>(near[i].size());
      means[i] = sum * (1 / static_cast<double>(near[i].size()));
    }
    const double edge = edges / edge_count;
    const std::vector<Vec> normals = normals_of(mesh);
    for (std::size_t i = 0; i < near.size(); ++i) {
      const Vec to_mean = means[i] - mesh.points[i];
      const double along = dot(to_mean, normals[i]);
      const Vec in_normal = normals[i] * along, in_surface = to_mean - in_normal;
      const double curvature = 2 * std::abs(along) / (edge * edge);
      const double smooth = 0.5 * (1 + std::tanh(kSlope * (curvature - kMiddle)));
      next[i] = mesh.points[i] + in_surface * 0.5 + in_normal * smooth +
                normals[i] * (0.05 * edge * push(scan, start, mesh.points[i], normals[i]));
    }
    mesh.points.swap(next);
  }
}

/// Marks (1) the voxels that a triangle crosses, without gaps between neighbouring voxels.
void draw(const Scan& scan, const std::array<Vec, 3>& corners, std::vector<std::uint8_t>& mask) {
  const Vec u = corners[1] - corners[0], v = corners[2] - corners[0];
  const double longest = std::max({length(u), length(v), length(corners[2] - corners[1])});
  const int steps = static_cast<int>(std::ceil(longest / (0.5 * scan.least_spacing()))) + 1;
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; i + j <= steps; ++j) {
      const Index at = scan.nearest(corners[0] + u * (double(i) / steps) + v * (double(j) / steps));
      if (scan.contains(at)) mask[scan.offset(at)] = 1;
    }
  }
}

/// Returns 1 for the voxels on and within the surface.
std::vector<std::uint8_t> inside_of(const Scan& scan, const Mesh& mesh) {
  const Index& size = scan.size();
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(size[0] * size[1] * size[2]));
  for (const auto& [a, b, c] : mesh.triangles) {
    draw(scan, {mesh.points[a], mesh.points[b], mesh.points[c]}, mask);
  }
  // Voxels beyond the box around the surface are outside (2), and so are those that can be reached
  // from them. The rest is inside. If the volume ends within the head, the surface leaves it, and
  // the border there is inside as well.
  std::vector<Index> open;  // the front of the flood, which is small even in a large volume
  const auto visit = [&](const Index& at) {
    if (!scan.contains(at)) return;
    std::uint8_t& state = mask[scan.offset(at)];
    if (state != 0) return;
    state = 2;
    open.push_back(at);
  };
  Vec low = mesh.points[0], high = low;
  for (const Vec& p : mesh.points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Index first = scan.nearest(low), last = scan.nearest(high);
  // Returns whether a voxel is in the box with this margin.
  const auto in_box = [&](const Index& at, std::int64_t margin) {
    for (std::size_t a = 0; a < 3; ++a) {
      if (at[a] + margin < first[a] || at[a] - margin > last[a]) return false;
    }
    return true;
  };
  for (std::int64_t z = 0; z < size[2]; ++z) {
    for (std::int64_t y = 0; y < size[1]; ++y) {
      for (std::int64_t x = 0; x < size[0]; ++x) {
        const Index at{x, y, z};
        if (in_box(at, 0)) continue;
        if (in_box(at, 1)) {
          visit(at);
        } else {
          mask[scan.offset(at)] = 2;
        }
      }
    }
  }
  while (!open.empty()) {
    const std::vector<Index> front = std::exchange(open, {});
    for (const auto& [x, y, z] : front) {
      for (const Index& next : {Index{x - 1, y, z}, Index{x + 1, y, z}, Index{x, y - 1, z},
                                Index{x, y + 1, z}, Index{x, y, z - 1}, Index{x, y, z + 1}}) {
        visit(next);
      }
    }
  }
  for (std::uint8_t& state : mask) state = state == 2 ? 0 : 1;
  return mask;
}

/// Returns the share of the surface that is darker just outside than inside, as the fluid around a
/// brain is, or beyond which there is nothing.
double share_of_edge(const Scan& scan, const Start& start, const Mesh& mesh) {
  const std::vector<Vec> normals = normals_of(mesh);
  std::size_t edges = 0;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    double inside = start.t2, outside = start.t98;
    for (double depth = 1; depth <= 8; depth += 1) {
      inside = std::max(inside, scan.at(mesh.points[i] - normals[i] * depth, start.t2));
    }
    for (double depth = -2; depth <= 4; depth += 1) {
      outside = std::min(outside, scan.at(mesh.points[i] + normals[i] * depth, start.t2));
    }
    if (outside - start.t2 < 0.6 * (std::min(inside, start.tm) - start.t2)) ++edges;
  }
  return static_cast<double>(edges) / static_cast<double>(mesh.points.size());
}

/// Returns the standard deviation of the distances from the middle, as a share of their mean.
double unevenness(const Mesh& mesh) {
  Vec sum;
  for (const Vec& point : mesh.points) sum = sum + point;
  const Vec middle = sum * (1 / static_cast<double>(mesh.points.size()));
  double total = 0, squares = 0;
  for (const Vec& point : mesh.points) {
    const double distance = length(point - middle);
    total += distance;
    squares += distance * distance;
  }
  const double n = static_cast<double>(mesh.points.size()), mean = total / n;
  return std::sqrt(std::max(0.0, squares / n - mean * mean)) / mean;
}

bool plausible(const Scan& scan, const Start& start, const Mesh& mesh,
               const std::vector<std::uint8_t>& mask) {
  constexpr double kEdgeAtLeast = 0.8, kUnevenAtMost = 0.22;
  const double ml =
      static_cast<double>(std::count(mask.begin(), mask.end(), 1)) * scan.voxel_mm3() / 1000;
  return ml >= kSmallest && ml <= kLargest && unevenness(mesh) <= kUnevenAtMost &&
         share_of_edge(scan, start, mesh) >= kEdgeAtLeast;
}

}  // namespace

bool mark_brain(const volume::Volume& volume, volume::Labels& labels) {
  const volume::Modality modality = volume.header.modality;
  if (modality == volume::Modality::kCt || modality == volume::Modality::kPt) return false;
  if (labels.voxels.empty() || is_hounsfield(volume.header)) return false;
  const Scan scan(volume, labels);
  if (scan.least_spacing() < kFinest) return false;
  const auto start = start_of(scan);
  if (!start || 4 * std::numbers::pi / 3 * std::pow(start->radius, 3) < kSmallest * 1000) {
    return false;
  }
  // The shape is found with few points, and its folds with four times as many.
  Mesh mesh = sphere(start->middle, start->radius / 2, 3);
  blow_up(scan, *start, mesh, 500);
  mesh = divided(mesh);
  blow_up(scan, *start, mesh, 200);
  const std::vector<std::uint8_t> mask = inside_of(scan, mesh);
  if (!plausible(scan, *start, mesh, mask)) return false;
  for (std::size_t voxel = 0; voxel < mask.size(); ++voxel) {
    if (mask[voxel] == 1 && scan.is_body(voxel)) {
      labels.voxels[voxel] = static_cast<std::uint8_t>(Label::kBrain);
    }
  }
  return true;
}

}  // namespace diaphane::ingest
