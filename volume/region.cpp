#include "volume/region.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/bounded_json.h"
#include "common/try.h"
#include "volume/header.h"

namespace diaphane::volume {
namespace {

using nlohmann::json;

/// No place in a scan is farther away. Sums and products of such numbers stay accurate enough.
constexpr double kFarthestMm = 1e5;

/// A box and six planes have 65 values on five levels.
constexpr JsonLimits kLimits{128, 8};

tl::unexpected<Error> wrong(const std::string& field, const std::string& what) {
  return fail(ErrorCode::kInvalid, what, field);
}

bool only(const json& object, std::initializer_list<const char*> names) {
  return object.is_object() &&
         std::all_of(object.items().begin(), object.items().end(), [&](const auto& item) {
           return std::find(names.begin(), names.end(), item.key()) != names.end();
         });
}

std::optional<Vector> vector_in(const json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_array() || found->size() != 3) return std::nullopt;
  Vector read{};
  for (std::size_t i = 0; i < 3; ++i) {
    const json& number = (*found)[i];
    if (!number.is_number()) return std::nullopt;
    read[i] = number.get<double>();
    if (!std::isfinite(read[i]) || std::abs(read[i]) > kFarthestMm) return std::nullopt;
  }
  return read;
}

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Vector& a) { return std::sqrt(dot(a, a)); }

KeptVoxels kept_by(const Header& header, const Region& region) {
  std::vector<Region::Plane> planes = faces_of(region.low, region.high);
  planes.insert(planes.end(), region.planes.begin(), region.planes.end());
  return {header, planes};
}

/// Returns the range of kept voxels along x in a row. They form an interval, because each side is
/// an affine function of x.
std::array<std::uint32_t, 2> along_x(const KeptVoxels& kept, std::uint32_t y, std::uint32_t z,
                                     std::uint32_t size) {
  // Tests single voxels at both ends, so that rounding never includes a voxel that `keeps` rejects.
  std::uint32_t first = 0, last = size;
  while (first < last && !kept.keeps(first, y, z)) ++first;
  while (last > first && !kept.keeps(last - 1, y, z)) --last;
  return {first, last};
}

}  // namespace

KeptVoxels::KeptVoxels(const Header& header, std::span<const Region::Plane> planes) {
  std::array<Vector, 3> step{};
  Vector first{};
  for (std::size_t voxel = 0; voxel < 3; ++voxel) {
    for (std::size_t patient = 0; patient < 3; ++patient) {
      step[voxel][patient] = header.direction[3 * patient + voxel] * header.spacing[voxel];
      first[patient] += step[voxel][patient] * (0.5 - header.size[voxel] / 2.0);
    }
  }
  for (const Region::Plane& plane : planes) {
    Side side;
    const double norm = length(plane.normal);
    for (std::size_t voxel = 0; voxel < 3; ++voxel) {
      side.slope[voxel] = dot(step[voxel], plane.normal) / norm;
    }
    side.at_origin = (dot(first, plane.normal) - dot(plane.point, plane.normal)) / norm;
    sides_.push_back(side);
  }
}

bool KeptVoxels::keeps(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
  // Tolerance of 1e-6 mm, so that a voxel with its centre exactly on the border is kept despite
  // rounding.
  constexpr double kRounding = 1e-6;
  return std::all_of(sides_.begin(), sides_.end(), [&](const Side& side) {
    return side.at_origin + side.slope[0] * x + side.slope[1] * y + side.slope[2] * z <= kRounding;
  });
}

std::vector<Region::Plane> faces_of(const Vector& low, const Vector& high) {
  std::vector<Region::Plane> faces;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vector normal{};
    normal[axis] = -1;
    faces.push_back({low, normal});
    normal[axis] = 1;
    faces.push_back({high, normal});
  }
  return faces;
}

Result<Region> region_from_json(const std::string& text) {
  const auto parsed = parse_json(text, kLimits);
  if (!parsed || !only(*parsed, {"box", "planes"})) {
    return wrong("keep", "must have a box and may have planes");
  }
  const json& body = *parsed;
  if (!body.contains("box") || !only(body["box"], {"low", "high"})) {
    return wrong("keep.box", "must have low and high");
  }
  const auto low = vector_in(body["box"], "low"), high = vector_in(body["box"], "high");
  if (!low) return wrong("keep.box.low", "must be three numbers in millimetres");
  if (!high) return wrong("keep.box.high", "must be three numbers in millimetres");
  Region region{*low, *high, {}};
  for (std::size_t i = 0; i < 3; ++i) {
    if (region.low[i] >= region.high[i]) return wrong("keep.box", "must have low below high");
  }
  const json planes = body.value("planes", json::array());
  if (!planes.is_array() || planes.size() > kMostPlanes) {
    return wrong("keep.planes", "must be a list of at most 6 planes");
  }
  for (const json& entry : planes) {
    if (!only(entry, {"point", "normal"})) return wrong("keep.planes", "has an unknown field");
    const auto point = vector_in(entry, "point"), normal = vector_in(entry, "normal");
    if (!point || !normal) return wrong("keep.planes", "must each have a point and a normal");
    if (!(length(*normal) > 1e-6))
      return wrong("keep.planes", "must have normals that are not zero");
    region.planes.push_back({*point, *normal});
  }
  return region;
}

std::string to_json(const Region& region) {
  json planes = json::array();
  for (const Region::Plane& plane : region.planes) {
    planes.push_back({{"point", plane.point}, {"normal", plane.normal}});
  }
  return json{{"box", {{"low", region.low}, {"high", region.high}}}, {"planes", planes}}.dump();
}

Result<Cut> plan_cut(const Header& header, const Region& region) {
  DIAPHANE_TRY(check(header));
  const KeptVoxels spaces = kept_by(header, region);
  std::array<std::uint32_t, 3> low = header.size, high{};
  Cut cut;
  for (std::uint32_t z = 0; z < header.size[2]; ++z) {
    for (std::uint32_t y = 0; y < header.size[1]; ++y) {
      const auto [first, last] = along_x(spaces, y, z, header.size[0]);
      if (first >= last) continue;
      cut.kept += last - first;
      const std::array<std::uint32_t, 3> begin{first, y, z}, end{last, y + 1, z + 1};
      for (std::size_t i = 0; i < 3; ++i) {
        low[i] = std::min(low[i], begin[i]);
        high[i] = std::max(high[i], end[i]);
      }
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (high[i] < low[i] + std::min(kLeastSide, header.size[i])) {
      return wrong("keep", "would leave too little of the scan");
    }
    cut.low[i] = low[i];
    cut.size[i] = high[i] - low[i];
  }
  for (std::size_t voxel = 0; voxel < 3; ++voxel) {
    const double moved = cut.low[voxel] + cut.size[voxel] / 2.0 - header.size[voxel] / 2.0;
    for (std::size_t patient = 0; patient < 3; ++patient) {
      cut.shift[patient] += header.direction[3 * patient + voxel] * header.spacing[voxel] * moved;
    }
  }
  constexpr std::int32_t kAirHounsfield = -1000;
  cut.air = static_cast<std::int16_t>(
      header.modality == Modality::kCt ? std::clamp(kAirHounsfield, header.minimum, header.maximum)
                                       : header.minimum);
  return cut;
}

Header after(const Header& header, const Cut& cut) {
  Header left = header;
  left.size = cut.size;
  left.minimum = left.maximum = 0;
  left.percentiles.fill(0);
  left.content_hash.clear();
  left.label_hash.clear();  // labels may show the shape of what was removed
  if (left.origin) {
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        (*left.origin)[row] +=
            header.direction[3 * row + axis] * header.spacing[axis] * cut.low[axis];
      }
    }
  }
  return left;
}

void cut_slice(const Header& header, const Region& region, const Cut& cut, std::uint32_t slice,
               std::span<const std::int16_t> from, std::span<std::int16_t> to) {
  const KeptVoxels spaces = kept_by(header, region);
  std::fill(to.begin(), to.end(), cut.air);
  const std::uint32_t z = cut.low[2] + slice;
  for (std::uint32_t row = 0; row < cut.size[1]; ++row) {
    const std::uint32_t y = cut.low[1] + row;
    const auto [first, last] = along_x(spaces, y, z, header.size[0]);
    if (first >= last) continue;
    const auto source = from.begin() + std::ptrdiff_t{y} * header.size[0];
    std::copy(source + first, source + last,
              to.begin() + std::ptrdiff_t{row} * cut.size[0] + (first - cut.low[0]));
  }
}

Result<Volume> cut_volume(const Volume& volume, const Region& region) {
  const auto cut = plan_cut(volume.header, region);
  DIAPHANE_TRY(cut);
  Volume left;
  left.header = after(volume.header, *cut);
  const std::size_t phases = volume.voxels.size() / volume.header.voxel_count();
  left.voxels.resize(phases * left.header.voxel_count());
  const std::size_t old_slice = std::size_t{volume.header.size[0]} * volume.header.size[1];
  const std::size_t new_slice = std::size_t{cut->size[0]} * cut->size[1];
  const std::span<const std::int16_t> from(volume.voxels);
  const std::span<std::int16_t> to(left.voxels);
  for (std::size_t k = 0; k < phases * cut->size[2]; ++k) {
    const std::size_t phase = k / cut->size[2];
    const auto z = static_cast<std::uint32_t>(k % cut->size[2]);
    const std::size_t slice = phase * volume.header.size[2] + cut->low[2] + z;
    cut_slice(volume.header, region, *cut, z, from.subspan(slice * old_slice, old_slice),
              to.subspan(k * new_slice, new_slice));
  }
  measure(left);
  return left;
}

}  // namespace diaphane::volume
