#include "ingest/build/image_volume.h"

#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkShortArray.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <type_traits>

#include "ingest/build/nifti.h"
#include "volume/header.h"

namespace diaphane::ingest {
namespace {

constexpr double kLargest = 32767;

/// How numbers of the file are converted to int16.
struct Scaling {
  double slope = 1;
  double intercept = 0;
  std::string repair;
};

/// Returns a scaling that keeps integers that fit. Scales larger numbers to fit, and floats of a
/// small range so that rounding does not flatten them.
Scaling scaling_for(double low, double high, bool is_float) {
  Scaling scaling;
  const double reach = std::max(std::abs(low), std::abs(high));
  constexpr double kFewSteps = 255;
  const bool flat = is_float && reach > 0 && high - low < kFewSteps;
  if (reach <= kLargest + 0.5 && !flat) return scaling;
  constexpr double kRound = 30000;  // leaves room for overshoot by interpolation
  constexpr double kLargestShort = 65535;
  scaling.slope = flat || is_float || reach > kLargestShort ? kRound / reach : 0.5;
  char text[80];
  std::snprintf(text, sizeof text, "values were multiplied by %.6g for storage", scaling.slope);
  scaling.repair = text;
  return scaling;
}

template <typename T>
void convert(const T* from, std::size_t count, double slope, double intercept, std::int16_t* to) {
  for (std::size_t i = 0; i < count; ++i) {
    const double value = slope * static_cast<double>(from[i]) + intercept;
    // NaN and infinity become 0.
    to[i] = std::isfinite(value)
                ? static_cast<std::int16_t>(std::lround(std::clamp(value, -32768.0, kLargest)))
                : std::int16_t{0};
  }
}

/// Returns the smallest and the largest finite value.
template <typename T>
std::array<double, 2> range_of(const T* from, std::size_t count) {
  std::array<double, 2> range{HUGE_VAL, -HUGE_VAL};
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = static_cast<double>(from[i]);
    if (!std::isfinite(value)) continue;
    range = {std::min(range[0], value), std::max(range[1], value)};
  }
  if (range[0] > range[1]) range = {0, 0};
  return range;
}

/// Stores voxels of one type in `volume`.
template <typename T>
void take_values(std::span<const std::byte> voxels, const ImageHeader& header,
                 volume::Volume& volume) {
  std::vector<std::byte> native;
  // Numbers need their natural alignment and this machine's byte order.
  if (header.swapped || reinterpret_cast<std::uintptr_t>(voxels.data()) % sizeof(T) != 0) {
    native.assign(voxels.begin(), voxels.end());
    for (auto at = native.begin(); header.swapped && at != native.end(); at += sizeof(T))
      std::reverse(at, at + sizeof(T));
    voxels = native;
  }
  const auto* from = reinterpret_cast<const T*>(voxels.data());
  const std::size_t count = volume.header.total_voxel_count();
  const double slope = header.slope, intercept = header.intercept;
  const bool is_float = std::is_floating_point_v<T> || (sizeof(T) > 1 && slope != 1);
  auto [low, high] = range_of(from, count);
  low = slope * low + intercept;
  high = slope * high + intercept;
  const Scaling scaling = scaling_for(std::min(low, high), std::max(low, high), is_float);
  if (!scaling.repair.empty()) volume.header.repairs.push_back(scaling.repair);
  volume.voxels.resize(count);
  convert(from, count, slope * scaling.slope, intercept * scaling.slope, volume.voxels.data());
}

void take_values_of(std::span<const std::byte> voxels, const ImageHeader& header,
                    volume::Volume& volume) {
  switch (header.type) {
    case VoxelType::kUint8:
      return take_values<std::uint8_t>(voxels, header, volume);
    case VoxelType::kInt8:
      return take_values<std::int8_t>(voxels, header, volume);
    case VoxelType::kUint16:
      return take_values<std::uint16_t>(voxels, header, volume);
    case VoxelType::kInt16:
      return take_values<std::int16_t>(voxels, header, volume);
    case VoxelType::kUint32:
      return take_values<std::uint32_t>(voxels, header, volume);
    case VoxelType::kInt32:
      return take_values<std::int32_t>(voxels, header, volume);
    case VoxelType::kFloat:
      return take_values<float>(voxels, header, volume);
    case VoxelType::kDouble:
      return take_values<double>(voxels, header, volume);
  }
}

/// Reverses the order of the slices of each phase.
void reverse_slices(volume::Volume& volume) {
  const auto& size = volume.header.size;
  const auto picture = static_cast<std::ptrdiff_t>(std::size_t{size[0]} * size[1]);
  for (std::uint32_t phase = 0; phase < volume.header.phase_count(); ++phase) {
    const auto begin =
        volume.voxels.begin() + static_cast<std::ptrdiff_t>(phase * volume.header.voxel_count());
    for (std::ptrdiff_t low = 0, high = size[2] - std::ptrdiff_t{1}; low < high; ++low, --high) {
      std::swap_ranges(begin + low * picture, begin + (low + 1) * picture, begin + high * picture);
    }
  }
}

}  // namespace

vtkSmartPointer<vtkImageData> borrow(volume::Volume& volume, std::uint32_t index) {
  const volume::Header& h = volume.header;
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(static_cast<int>(h.size[0]), static_cast<int>(h.size[1]),
                       static_cast<int>(h.size[2]));
  image->SetSpacing(h.spacing.data());
  image->SetDirectionMatrix(h.direction.data());
  vtkNew<vtkShortArray> scalars;
  constexpr int kDoNotFree = 1;
  scalars->SetArray(volume.voxels.data() + index * h.voxel_count(),
                    static_cast<vtkIdType>(h.voxel_count()), kDoNotFree);
  image->GetPointData()->SetScalars(scalars);
  return image;
}

Result<volume::Volume> to_volume(std::span<const std::byte> voxels, const ImageHeader& header) {
  volume::Volume volume;
  volume::Header& h = volume.header;
  if (!header.has_axes) h.repairs.emplace_back(kNoAxes);
  h.size = header.size;
  h.origin = header.origin;
  h.phases = header.phases;
  h.modality = header.modality;
  const auto& axes = header.axes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double step = std::hypot(axes[axis], axes[3 + axis], axes[6 + axis]);
    h.spacing[axis] = step;
    for (std::size_t row = 0; row < 3; ++row)
      h.direction[3 * row + axis] = axes[3 * row + axis] / step;
  }
  // For left-handed axes, reversing the slices and their axis gives the same image without
  // mirroring.
  const bool reversed = vtkMatrix3x3::Determinant(h.direction.data()) < 0;
  if (reversed) {
    for (std::size_t row = 0; row < 3; ++row) {
      h.direction[3 * row + 2] *= -1;
      if (h.origin) (*h.origin)[row] += (h.size[2] - 1.0) * axes[3 * row + 2];
    }
  }
  if (auto ok = volume::check(h); !ok) {
    return fail(ErrorCode::kUnsupported, "the image cannot be shown: " + ok.error().message);
  }
  take_values_of(voxels, header, volume);
  if (reversed) reverse_slices(volume);
  volume::measure(volume);
  return volume;
}

Result<volume::Volume> read_nifti_voxels(std::span<const std::byte> file,
                                         const NiftiHeader& header) {
  return to_volume(file.subspan(header.voxels_begin, header.voxels_bytes()), header);
}

}  // namespace diaphane::ingest
