#include "ingest/build/nrrd.h"

#include <NrrdIO.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <new>
#include <optional>

#include "common/try.h"

namespace diaphane::ingest {
namespace {

struct Free {
  void operator()(Nrrd* nrrd) const { nrrdNuke(nrrd); }
  void operator()(NrrdIoState* state) const { nrrdIoStateNix(state); }
};
using NrrdFile = std::unique_ptr<Nrrd, Free>;

/// Reads a file, or only its header.
Result<NrrdFile> load(const std::string& path, bool header_only) {
  NrrdFile nrrd(nrrdNew());
  const std::unique_ptr<NrrdIoState, Free> state(nrrdIoStateNew());
  if (!nrrd || !state) return fail(ErrorCode::kOutOfMemory, "the image does not fit in memory");
  state->skipData = header_only ? 1 : 0;
  if (nrrdLoad(nrrd.get(), path.c_str(), state.get()) != 0) {
    biffDone(NRRD);  // the text may contain names of files
    return fail(ErrorCode::kInvalid,
                "the image is damaged or incomplete, or its encoding is not supported");
  }
  return nrrd;
}

std::optional<VoxelType> nrrd_type(int type) {
  static const std::map<int, VoxelType> kNrrdTypes{
      {nrrdTypeChar, VoxelType::kInt8},   {nrrdTypeUChar, VoxelType::kUint8},
      {nrrdTypeShort, VoxelType::kInt16}, {nrrdTypeUShort, VoxelType::kUint16},
      {nrrdTypeInt, VoxelType::kInt32},   {nrrdTypeUInt, VoxelType::kUint32},
      {nrrdTypeFloat, VoxelType::kFloat}, {nrrdTypeDouble, VoxelType::kDouble}};
  const auto found = kNrrdTypes.find(type);
  return found == kNrrdTypes.end() ? std::nullopt : std::optional(found->second);
}

bool has_direction(const Nrrd& nrrd, std::size_t axis) {
  return nrrd.spaceDim >= 3 && std::isfinite(nrrd.axis[axis].spaceDirection[0]);
}

bool is_domain(int kind) {
  return kind == nrrdKindUnknown || kind == nrrdKindDomain || kind == nrrdKindSpace;
}

/// Returns whether an axis runs through space. In a space with time, the direction of the axis of
/// time has a fourth component only.
bool is_spatial(const Nrrd& nrrd, std::size_t axis) {
  if (nrrd.spaceDim == 0) return is_domain(nrrd.axis[axis].kind);
  if (!has_direction(nrrd, axis)) return false;
  const double* step = nrrd.axis[axis].spaceDirection;
  return step[0] != 0 || step[1] != 0 || step[2] != 0;
}

/// The numbers of three axes of space, and of the axis of phases, if there is one.
struct Roles {
  std::array<std::size_t, 3> spatial{};
  std::optional<std::size_t> phases;
};

/// Returns the roles of the axes, or kUnsupported if they are those of vectors or colours.
Result<Roles> roles_of(const Nrrd& nrrd) {
  std::vector<std::size_t> spatial, others;
  for (std::size_t axis = 0; axis < nrrd.dim; ++axis) {
    (is_spatial(nrrd, axis) ? spatial : others).push_back(axis);
  }
  if (spatial.size() == 4 && others.empty()) {  // nothing tells time from space
    others = {spatial[3]};
    spatial.pop_back();
  }
  std::erase_if(others, [&](std::size_t axis) { return nrrd.axis[axis].size == 1; });
  if (spatial.size() != 3) {
    return fail(ErrorCode::kUnsupported, "only images with three spatial dimensions are supported");
  }
  Roles roles;
  std::copy(spatial.begin(), spatial.end(), roles.spatial.begin());
  if (others.empty()) return roles;
  if (others.size() > 1) return several_values();
  const auto& axis = nrrd.axis[others[0]];
  // Programs that write no kinds put the parts of a vector or a colour in front.
  constexpr std::size_t kMostParts = 4;
  const bool is_unnamed_vector =
      axis.kind == nrrdKindUnknown && others[0] == 0 && axis.size <= kMostParts;
  const bool counts =
      is_domain(axis.kind) || axis.kind == nrrdKindTime || axis.kind == nrrdKindList;
  if (!counts || is_unnamed_vector) return several_values();
  roles.phases = others[0];
  return roles;
}

/// Returns the milliseconds of a unit of time, or 0 for another unit or none.
double milliseconds_of(const char* unit) {
  static const std::map<std::string, double> kUnits{
      {"s", 1000},  {"sec", 1000},  {"second", 1000},      {"seconds", 1000},
      {"ms", 1},    {"msec", 1},    {"millisecond", 1},    {"milliseconds", 1},
      {"us", 1e-3}, {"usec", 1e-3}, {"microsecond", 1e-3}, {"microseconds", 1e-3}};
  const auto found = kUnits.find(unit == nullptr ? "" : unit);
  return found == kUnits.end() ? 0 : found->second;
}

/// Returns the time from phase to phase in ms, or 0 if the file does not state it.
double step_of(const Nrrd& nrrd, std::size_t axis) {
  constexpr std::size_t kTime = 3;
  if (nrrd.spaceDim == 4 && has_direction(nrrd, axis)) {
    return nrrd.axis[axis].spaceDirection[kTime] * milliseconds_of(nrrd.spaceUnits[kTime]);
  }
  const double step = nrrd.axis[axis].spacing * milliseconds_of(nrrd.axis[axis].units);
  return std::isfinite(step) ? step : 0;
}

/// Returns the signs that convert the coordinates of a space to LPS, or nullopt if the space is not
/// that of a patient.
std::optional<std::array<double, 3>> signs_of(int space) {
  switch (space) {
    case nrrdSpaceLeftPosteriorSuperior:
    case nrrdSpaceLeftPosteriorSuperiorTime:
      return {{1, 1, 1}};
    case nrrdSpaceRightAnteriorSuperior:
    case nrrdSpaceRightAnteriorSuperiorTime:
      return {{-1, -1, 1}};
    case nrrdSpaceLeftAnteriorSuperior:
    case nrrdSpaceLeftAnteriorSuperiorTime:
      return {{1, -1, 1}};
    default:
      return std::nullopt;
  }
}

void place_nrrd(const Nrrd& nrrd, const Roles& roles, ImageHeader& header) {
  const auto signs = signs_of(nrrd.space);
  header.has_axes = signs.has_value() && nrrd.spaceDim >= 3;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& one = nrrd.axis[roles.spatial[axis]];
    const double* step = one.spaceDirection;
    if (header.has_axes) {
      for (std::size_t row = 0; row < 3; ++row)
        header.axes[3 * row + axis] = (*signs)[row] * step[row];
    } else {
      const double spacing = nrrd.spaceDim >= 3           ? std::hypot(step[0], step[1], step[2])
                             : std::isfinite(one.spacing) ? std::abs(one.spacing)
                                                          : 1;
      header.axes[4 * axis] = spacing;
    }
  }
  const double* origin = nrrd.spaceOrigin;
  if (header.has_axes && std::all_of(origin, origin + 3, [](double x) { return std::isfinite(x); }))
    header.origin = {(*signs)[0] * origin[0], (*signs)[1] * origin[1], (*signs)[2] * origin[2]};
}

/// Copies the voxels phase by phase, wherever the axis of the phases is.
std::vector<std::byte> by_phase(const Nrrd& nrrd, const Roles& roles, const ImageHeader& header) {
  std::vector<std::byte> voxels(header.voxels_bytes());
  const auto* from = static_cast<const std::byte*>(nrrd.data);
  const std::size_t phases = std::max<std::size_t>(header.phases.size(), 1);
  std::size_t run = bytes_of(header.type);  // bytes of the axes before that of the phases
  for (std::size_t axis = 0; axis < roles.phases.value_or(nrrd.dim); ++axis)
    run *= nrrd.axis[axis].size;
  const std::size_t runs = voxels.size() / run / phases;
  for (std::size_t at = 0; at < runs; ++at) {
    for (std::size_t phase = 0; phase < phases; ++phase) {
      std::memcpy(voxels.data() + (phase * runs + at) * run, from + (at * phases + phase) * run,
                  run);
    }
  }
  return voxels;
}

}  // namespace

Result<Image> read_nrrd(const std::string& path) {
  const auto described = load(path, /*header_only=*/true);
  DIAPHANE_TRY(described);
  const Nrrd& known = **described;
  const auto type = nrrd_type(known.type);
  if (!type) return unknown_type();
  const auto roles = roles_of(known);
  DIAPHANE_TRY(roles);
  Image image;
  image.header.type = *type;
  std::array<std::int64_t, 3> size{};
  for (std::size_t i = 0; i < 3; ++i)
    size[i] = static_cast<std::int64_t>(known.axis[roles->spatial[i]].size);
  const auto phases =
      roles->phases ? static_cast<std::int64_t>(known.axis[*roles->phases].size) : 1;
  DIAPHANE_TRY(
      set_size(image.header, size, phases, roles->phases ? step_of(known, *roles->phases) : 0));
  place_nrrd(known, *roles, image.header);
  const auto file = load(path, /*header_only=*/false);
  DIAPHANE_TRY(file);
  if ((*file)->data == nullptr) return damaged_image();
  try {
    image.voxels = by_phase(**file, *roles, image.header);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "the image does not fit in memory");
  }
  return image;
}

}  // namespace diaphane::ingest
