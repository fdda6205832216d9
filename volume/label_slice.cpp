#include "volume/label_slice.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "volume/second_slice.h"

namespace diaphane::volume {
namespace {

/// Samples of each pixel along the normal of a slab. A plane has one.
struct Layers {
  Vector step{};  ///< mm
  std::uint64_t count = 1;
};

Vector in_voxels(const Header& header, const Vector& world) {
  Vector voxels{};
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t k = 0; k < 3; ++k) voxels[a] += header.direction[3 * k + a] * world[k];
    voxels[a] /= header.spacing[a];
  }
  return voxels;
}

/// Counts the labels of one pixel.
class Votes {
 public:
  void add(std::uint8_t label) {
    if (label == 0) return;
    if (counts_[label]++ == 0) present_.push_back(label);
  }
  /// Returns the most frequent label, or 0, and starts again.
  std::uint8_t take() {
    std::uint8_t best = 0;
    for (const std::uint8_t label : present_) {
      if (counts_[label] > counts_[best] || (counts_[label] == counts_[best] && label < best)) {
        best = label;
      }
    }
    for (const std::uint8_t label : present_) counts_[label] = 0;
    present_.clear();
    return best;
  }

 private:
  std::array<std::uint32_t, kMostLabels + 1> counts_{};
  std::vector<std::uint8_t> present_;
};

/// Returns the label of the voxel at a position in voxels, where voxel i covers [i, i + 1).
std::uint8_t label_at(const Volume& volume, const Vector& position, const ClippedSlice* clipped) {
  const auto& size = volume.header.size;
  std::array<std::uint32_t, 3> voxel{};
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(position[a] >= 0 && position[a] < size[a])) return 0;
    voxel[a] = static_cast<std::uint32_t>(position[a]);
  }
  if (clipped && !clipped->kept.keeps(voxel[0], voxel[1], voxel[2])) return 0;
  return volume.label_set.labels
      .voxels[voxel[0] + size[0] * (voxel[1] + std::size_t{size[1]} * voxel[2])];
}

std::vector<std::uint8_t> read(const Volume& volume, const PixelGrid& pixels, const Layers& layers,
                               const ClippedSlice* clipped) {
  const Header& header = volume.header;
  Vector first = in_voxels(header, pixels.first);
  const Vector right = in_voxels(header, pixels.right);
  const Vector down = in_voxels(header, pixels.down);
  const Vector through = in_voxels(header, layers.step);
  for (std::size_t a = 0; a < 3; ++a) {
    first[a] += header.size[a] / 2.0 - static_cast<double>(layers.count - 1) / 2 * through[a];
  }
  std::vector<std::uint8_t> labels(std::size_t{pixels.columns} * pixels.rows);
  Votes votes;
  for (std::size_t pixel = 0; pixel < labels.size(); ++pixel) {
    if (clipped && clipped->values[pixel] == kBlank) continue;
    const std::size_t row = pixel / pixels.columns;
    const auto across = static_cast<double>(pixel % pixels.columns);
    const auto along = static_cast<double>(row);
    for (std::uint64_t layer = 0; layer < layers.count; ++layer) {
      Vector at{};
      for (std::size_t a = 0; a < 3; ++a) {
        at[a] = first[a] + across * right[a] + along * down[a] +
                static_cast<double>(layer) * through[a];
      }
      votes.add(label_at(volume, at, clipped));
    }
    labels[pixel] = votes.take();
  }
  return labels;
}

}  // namespace

std::vector<std::uint8_t> labels_of_slice(const Volume& volume, const SliceStack& stack,
                                          std::uint32_t index, const ClippedSlice* clipped) {
  return read(volume, pixels_of(stack, index), {}, clipped);
}

std::vector<std::uint8_t> labels_of_slice(const Volume& volume, const ObliqueSlice& slice,
                                          const ClippedSlice* clipped) {
  Layers layers{{}, layers_of(volume.header, slice.thickness)};
  if (layers.count > 1) {
    layers.step = normal_of(slice);
    for (double& entry : layers.step) {
      entry *= slice.thickness / static_cast<double>(layers.count - 1);
    }
  }
  return read(volume, pixels_of(slice), layers, clipped);
}

}  // namespace diaphane::volume
