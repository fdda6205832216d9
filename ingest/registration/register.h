#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"
#include "volume/alignment.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// A scan on a grid that is coarse enough to align: means of its voxels.
struct CoarseScan {
  std::array<std::uint32_t, 3> size{};
  std::array<double, 3> spacing{};  ///< mm
  std::array<double, 9> direction{};
  std::array<double, 3> origin{};  ///< centre of the first voxel, mm (LPS)
  std::vector<float> values;       ///< x fastest

  std::array<double, 3> point(const std::array<double, 3>& index) const;
};

/// Computes a CoarseScan from the slices of a scan in order, so that the voxels need not be in
/// memory. The result has at most about a million voxels.
class ScanReducer {
 public:
  explicit ScanReducer(const volume::Header& header);
  /// Takes the voxels of the next slice along z.
  void add_slice(std::span<const std::int16_t> voxels);
  /// Requires that all slices were added.
  CoarseScan finish();

 private:
  std::array<std::uint32_t, 3> factor_{};
  std::uint32_t slices_ = 0;
  std::array<std::uint32_t, 3> stored_{};
  CoarseScan scan_;
};
/// Reduces one phase of a volume in memory.
CoarseScan reduced(const volume::Volume& volume);

/// How one scan lies in the space of another.
struct RigidAlignment {
  volume::Matrix to_fixed = volume::kIdentity;  ///< from mm (LPS) of the moving scan to the fixed
  /// How far an alignment from one half of the data puts a place from where the alignment from all
  /// of it puts it: the root mean square over places in both scans and over four halves. If both
  /// halves are independent, this estimates the error of the whole (the variance of an estimate
  /// from half of the data is twice that of the whole, of which it contains a half). It contains no
  /// error that all halves share, such as organs that have moved.
  double residual_mm = 0;
  double overlap = 0;  ///< share of the smaller scan's box that lies in the other, in [0, 1]
  /// Mutual information of the values in nats, before and after.
  double information_before = 0, information = 0;
};

/// Aligns two scans by a rotation and a shift that maximise the mutual information of their values
/// (Mattes et al. 2003, by ITK). It starts from the positions in the headers, from the centres of
/// the boxes and from the centres of mass, at several angles. The result depends on the arguments
/// only.
///
/// Fails with kUnsupported. `Error::field` is then "no_structure" (a scan has one value only),
/// "little_overlap", or "not_converged": alignments from different halves disagree by more than a
/// twentieth of the smaller scan, or the information is not above that of other positions.
Result<RigidAlignment> register_rigid(const CoarseScan& fixed, const CoarseScan& moving,
                                      std::uint64_t seed = 1);

}  // namespace diaphane::ingest
