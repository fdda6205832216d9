#include "ingest/export/mesh.h"

#include <algorithm>
#include <cmath>

namespace diaphane::ingest {
namespace {

using Vector = std::array<double, 3>;

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vector difference(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  return {double{a[0]} - b[0], double{a[1]} - b[1], double{a[2]} - b[2]};
}

/// Returns a number per directed edge.
std::vector<std::uint64_t> edges_of(const Mesh& mesh, bool reversed) {
  std::vector<std::uint64_t> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint64_t from = triangle[i], to = triangle[(i + 1) % 3];
      if (reversed) std::swap(from, to);
      edges.push_back(from << 32 | to);
    }
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

bool has_equal_points(const Mesh& mesh) {
  auto points = mesh.points;
  std::sort(points.begin(), points.end());
  return std::adjacent_find(points.begin(), points.end()) != points.end();
}

}  // namespace

bool is_closed(const Mesh& mesh) {
  for (const auto& [a, b, c] : mesh.triangles) {
    if (a == b || b == c || c == a) return false;
  }
  const auto edges = edges_of(mesh, false);
  const bool once = std::adjacent_find(edges.begin(), edges.end()) == edges.end();
  return once && edges == edges_of(mesh, true) && !has_equal_points(mesh);
}

double enclosed_volume(const Mesh& mesh) {
  if (mesh.points.empty()) return 0;
  const auto& apex = mesh.points.front();
  double sixfold = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    sixfold += dot(difference(mesh.points[a], apex),
                   cross(difference(mesh.points[b], apex), difference(mesh.points[c], apex)));
  }
  return sixfold / 6;
}

std::vector<std::array<float, 3>> normals_of(const Mesh& mesh) {
  std::vector<Vector> sums(mesh.points.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    // Its length is twice the area.
    const Vector across = cross(difference(mesh.points[b], mesh.points[a]),
                                difference(mesh.points[c], mesh.points[a]));
    for (const std::uint32_t point : {a, b, c}) {
      for (std::size_t axis = 0; axis < 3; ++axis) sums[point][axis] += across[axis];
    }
  }
  std::vector<std::array<float, 3>> normals;
  normals.reserve(sums.size());
  for (const Vector& sum : sums) {
    const double length = std::sqrt(dot(sum, sum));
    // Opposite triangles at a thin place may cancel out. Any unit vector is valid there.
    if (!(length > 0)) {
      normals.push_back({0, 0, 1});
    } else {
      normals.push_back({static_cast<float>(sum[0] / length), static_cast<float>(sum[1] / length),
                         static_cast<float>(sum[2] / length)});
    }
  }
  return normals;
}

}  // namespace diaphane::ingest
