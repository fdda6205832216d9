#include <algorithm>
#include <cmath>

#include "ingest/registration/register.h"

namespace diaphane::ingest {
namespace {

constexpr double kMostVoxels = 1e6;

}  // namespace

std::array<double, 3> CoarseScan::point(const std::array<double, 3>& index) const {
  std::array<double, 3> p = origin;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      p[row] += direction[3 * row + axis] * spacing[axis] * index[axis];
    }
  }
  return p;
}

ScanReducer::ScanReducer(const volume::Header& header) : stored_(header.size) {
  double box = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) box *= header.size[axis] * header.spacing[axis];
  const double edge = std::cbrt(box / kMostVoxels);
  scan_.direction = header.direction;
  scan_.origin = volume::first_voxel(header);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // A rest of the last voxels is left out, because a mean of fewer voxels would be noisier.
    factor_[axis] = static_cast<std::uint32_t>(
        std::clamp(std::round(edge / header.spacing[axis]), 1.0, header.size[axis] * 1.0));
    scan_.size[axis] = header.size[axis] / factor_[axis];
    scan_.spacing[axis] = header.spacing[axis] * factor_[axis];
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double shift = header.spacing[axis] * (factor_[axis] - 1) / 2;
    for (std::size_t row = 0; row < 3; ++row) {
      scan_.origin[row] += header.direction[3 * row + axis] * shift;
    }
  }
  scan_.values.assign(std::size_t{scan_.size[0]} * scan_.size[1] * scan_.size[2], 0.0F);
}

void ScanReducer::add_slice(std::span<const std::int16_t> voxels) {
  const std::uint32_t z = slices_++ / factor_[2];
  if (z >= scan_.size[2]) return;
  const float share = 1.0F / static_cast<float>(factor_[0] * factor_[1] * factor_[2]);
  for (std::uint32_t y = 0; y < scan_.size[1] * factor_[1]; ++y) {
    const std::int16_t* row = voxels.data() + std::size_t{stored_[0]} * y;
    float* out =
        scan_.values.data() + scan_.size[0] * (y / factor_[1] + std::size_t{scan_.size[1]} * z);
    for (std::uint32_t x = 0; x < scan_.size[0] * factor_[0]; ++x) {
      out[x / factor_[0]] += share * static_cast<float>(row[x]);
    }
  }
}

CoarseScan ScanReducer::finish() { return std::move(scan_); }

CoarseScan reduced(const volume::Volume& volume) {
  ScanReducer reducer(volume.header);
  const std::size_t slice = std::size_t{volume.header.size[0]} * volume.header.size[1];
  const std::span<const std::int16_t> voxels(volume.voxels);
  for (std::uint32_t z = 0; z < volume.header.size[2]; ++z) {
    reducer.add_slice(voxels.subspan(slice * z, slice));
  }
  return reducer.finish();
}

}  // namespace diaphane::ingest
