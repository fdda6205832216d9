#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace diaphane::ingest {

/// Triangles with shared points, in mm in the patient's space (LPS). Seen from outside, the points
/// of a triangle run anticlockwise.
struct Mesh {
  std::vector<std::array<float, 3>> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::array<std::uint8_t, 3> colour{0xe6, 0xe0, 0xd2};  ///< sRGB
};

/// Returns whether each edge belongs to exactly two triangles, which pass through it in opposite
/// directions, so that the mesh has no holes, and whether no two points are equal.
bool is_closed(const Mesh& mesh);

/// Returns the enclosed volume in mm³. Positive if the triangles face outwards.
double enclosed_volume(const Mesh& mesh);

/// Returns the unit normals of the points, weighted by the areas of their triangles.
std::vector<std::array<float, 3>> normals_of(const Mesh& mesh);

}  // namespace diaphane::ingest
