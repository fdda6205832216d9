// VTK's writers of these formats only write to files by name, which the sandbox forbids, and that
// of glTF writes no .glb.
#include "ingest/export/mesh_writer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

#include "common/try.h"

namespace diaphane::ingest {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 16;  // bytes that are collected for the sink

template <typename T>
void append(std::string& text, const T& value) {
  text.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <typename T>
std::string_view bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

std::array<float, 3> normal_of(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
  const Mesh one{{mesh.points[triangle[0]], mesh.points[triangle[1]], mesh.points[triangle[2]]},
                 {{0, 1, 2}},
                 {}};
  return normals_of(one).front();
}

/// Converts from LPS to glTF's axes: left, head, front.
std::array<float, 3> turned(const std::array<float, 3>& lps) { return {lps[0], lps[2], -lps[1]}; }

double linear(std::uint8_t srgb) {
  const double c = srgb / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

struct Vertices {
  std::vector<std::array<float, 3>> points, normals;
  std::array<float, 3> low{}, high{};
};

Vertices vertices_of(const Mesh& mesh) {
  constexpr float kMetre = 0.001F;
  Vertices vertices;
  vertices.normals = normals_of(mesh);
  for (auto& normal : vertices.normals) normal = turned(normal);
  vertices.points.reserve(mesh.points.size());
  for (const auto& point : mesh.points) {
    auto at = turned(point);
    for (float& one : at) one *= kMetre;
    if (vertices.points.empty()) vertices.low = vertices.high = at;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      vertices.low[axis] = std::min(vertices.low[axis], at[axis]);
      vertices.high[axis] = std::max(vertices.high[axis], at[axis]);
    }
    vertices.points.push_back(at);
  }
  return vertices;
}

std::string gltf_of(const Mesh& mesh, const Vertices& vertices) {
  constexpr int kFloat = 5126, kUint32 = 5125, kVertices = 34962, kIndices = 34963;
  using Json = nlohmann::ordered_json;
  const std::size_t points = bytes_of(vertices.points).size();
  const std::size_t indices = bytes_of(mesh.triangles).size();
  const Json colour{linear(mesh.colour[0]), linear(mesh.colour[1]), linear(mesh.colour[2]), 1.0};
  const Json gltf{
      {"asset", {{"version", "2.0"}, {"generator", "Diaphane"}}},
      {"scene", 0},
      {"scenes", Json::array({{{"nodes", {0}}}})},
      {"nodes", Json::array({{{"mesh", 0}}})},
      {"meshes",
       Json::array({{{"primitives", Json::array({{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}}},
                                                  {"indices", 2},
                                                  {"material", 0}}})}}})},
      {"materials",
       Json::array(
           {{{"pbrMetallicRoughness",
              {{"baseColorFactor", colour}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.6}}}}})},
      {"accessors", Json::array({{{"bufferView", 0},
                                  {"componentType", kFloat},
                                  {"count", vertices.points.size()},
                                  {"type", "VEC3"},
                                  {"min", vertices.low},
                                  {"max", vertices.high}},
                                 {{"bufferView", 1},
                                  {"componentType", kFloat},
                                  {"count", vertices.normals.size()},
                                  {"type", "VEC3"}},
                                 {{"bufferView", 2},
                                  {"componentType", kUint32},
                                  {"count", 3 * mesh.triangles.size()},
                                  {"type", "SCALAR"}}})},
      {"bufferViews",
       Json::array(
           {{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", points}, {"target", kVertices}},
            {{"buffer", 0}, {"byteOffset", points}, {"byteLength", points}, {"target", kVertices}},
            {{"buffer", 0},
             {"byteOffset", 2 * points},
             {"byteLength", indices},
             {"target", kIndices}}})},
      {"buffers", Json::array({{{"byteLength", 2 * points + indices}}})}};
  std::string text = gltf.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  return text;
}

}  // namespace

Result<void> write_stl(const Mesh& mesh, const Sink& sink) {
  constexpr std::size_t kHeader = 80;
  // It must not begin with "solid", which marks a text file.
  std::string piece = "Diaphane; SPACE=LPS; UNIT=mm";
  piece.resize(kHeader, ' ');
  append(piece, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) {
    append(piece, normal_of(mesh, triangle));
    for (const std::uint32_t point : triangle) append(piece, mesh.points[point]);
    append(piece, std::uint16_t{0});
    if (piece.size() < kPiece) continue;
    DIAPHANE_TRY(sink(piece));
    piece.clear();
  }
  return sink(piece);
}

Result<void> write_glb(const Mesh& mesh, const Sink& sink) {
  const Vertices vertices = vertices_of(mesh);
  const std::string json = gltf_of(mesh, vertices);
  const std::array<std::string_view, 3> parts{bytes_of(vertices.points), bytes_of(vertices.normals),
                                              bytes_of(mesh.triangles)};
  std::size_t bytes = 0;  // a multiple of 4, as required, because all numbers have 4 bytes
  for (const auto part : parts) bytes += part.size();
  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  constexpr std::uint32_t kVersion = 2, kJson = 0x4E4F534A, kBinary = 0x004E4942;
  std::string head = "glTF";
  append(head, kVersion);
  append(head, static_cast<std::uint32_t>(kHeader + 2 * kChunkHeader + json.size() + bytes));
  append(head, static_cast<std::uint32_t>(json.size()));
  append(head, kJson);
  head += json;
  append(head, static_cast<std::uint32_t>(bytes));
  append(head, kBinary);
  DIAPHANE_TRY(sink(head));
  for (const auto part : parts) DIAPHANE_TRY(sink(part));
  return {};
}

}  // namespace diaphane::ingest
