#pragma once

#include <array>
#include <span>
#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::volume {

/// A row-major 4 x 4 matrix that maps points in mm (LPS) of one scan to those of another.
using Matrix = std::array<double, 16>;
inline constexpr Matrix kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

/// Returns whether two scans are in one patient space, so that the identity aligns them.
bool share_frame_of_reference(const Header& a, const Header& b);

/// Checks a matrix from a client or a file: 16 finite numbers that form a rotation and a shift of
/// at most 10 m. An empty matrix is the identity. Fails with kInvalid.
Result<Matrix> rigid_motion(std::span<const double> numbers);

/// Returns the numbers, separated by spaces, without loss (directory/placement.h).
std::string text_of(const Matrix& matrix);

Matrix product(const Matrix& a, const Matrix& b);
std::array<double, 3> moved(const Matrix& matrix, const std::array<double, 3>& point);
/// Returns the inverse of a rigid motion.
Matrix inverse_of_rigid(const Matrix& matrix);

/// Returns the centre of voxel (0, 0, 0) in mm (LPS). If the position of the scan is unknown, the
/// centre of its box is the origin.
std::array<double, 3> first_voxel(const Header& header);

/// Returns the affine map from voxel indices of one scan, where the centre of voxel (i, j, k) is at
/// (i, j, k) + 1/2, to those of another. `to_first` maps the points of `second` to those of
/// `first`.
Matrix between_indices(const Header& first, const Header& second, const Matrix& to_first);

/// Returns the affine map from world coordinates of `first` (api/proto/scene.proto) to voxel
/// indices of `second`.
Matrix indices_from_world(const Header& first, const Header& second, const Matrix& to_first);

}  // namespace diaphane::volume
