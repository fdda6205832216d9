#include "volume/alignment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <sstream>

namespace diaphane::volume {
namespace {

/// Returns the map from voxel indices to mm (LPS).
Matrix points_of_indices(const Header& header) {
  Matrix matrix = kIdentity;
  const std::array<double, 3> first = first_voxel(header);
  for (std::size_t row = 0; row < 3; ++row) {
    matrix[4 * row + 3] = first[row];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double step = header.direction[3 * row + axis] * header.spacing[axis];
      matrix[4 * row + axis] = step;
      matrix[4 * row + 3] -= step / 2;
    }
  }
  return matrix;
}

/// Returns the inverse of points_of_indices().
Matrix indices_of_points(const Header& header) {
  const Matrix forward = points_of_indices(header);
  Matrix matrix = kIdentity;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    matrix[4 * axis + 3] = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      const double step = header.direction[3 * row + axis] / header.spacing[axis];
      matrix[4 * axis + row] = step;
      matrix[4 * axis + 3] -= step * forward[4 * row + 3];
    }
  }
  return matrix;
}

}  // namespace

bool share_frame_of_reference(const Header& a, const Header& b) {
  return !a.frame_of_reference.empty() && a.frame_of_reference == b.frame_of_reference &&
         a.origin && b.origin;
}

Result<Matrix> rigid_motion(std::span<const double> numbers) {
  if (numbers.empty()) return kIdentity;
  constexpr double kTolerance = 1e-4, kFurthest = 1e4;
  const auto invalid = [] {
    return fail(ErrorCode::kInvalid, "an alignment must be a rotation and a shift of at most 10 m",
                "alignment");
  };
  if (numbers.size() != 16) return invalid();
  Matrix m{};
  std::copy(numbers.begin(), numbers.end(), m.begin());
  if (!std::all_of(m.begin(), m.end(), [](double n) { return std::abs(n) <= kFurthest; }))
    return invalid();
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      double dot = 0;
      for (std::size_t k = 0; k < 3; ++k) dot += m[4 * i + k] * m[4 * j + k];
      if (std::abs(dot - (i == j ? 1 : 0)) > kTolerance) return invalid();
    }
  }
  const double determinant = m[0] * (m[5] * m[10] - m[6] * m[9]) -
                             m[1] * (m[4] * m[10] - m[6] * m[8]) +
                             m[2] * (m[4] * m[9] - m[5] * m[8]);
  const bool last_row = m[12] == 0 && m[13] == 0 && m[14] == 0 && m[15] == 1;
  if (determinant < 0 || !last_row) return invalid();
  return m;
}

std::string text_of(const Matrix& matrix) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(std::numeric_limits<double>::max_digits10);
  for (const double number : matrix) text << (text.tellp() > 0 ? " " : "") << number;
  return text.str();
}

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix out{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t k = 0; k < 4; ++k) out[4 * i + j] += a[4 * i + k] * b[4 * k + j];
    }
  }
  return out;
}

std::array<double, 3> moved(const Matrix& matrix, const std::array<double, 3>& point) {
  std::array<double, 3> out{};
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] = matrix[4 * i + 3];
    for (std::size_t j = 0; j < 3; ++j) out[i] += matrix[4 * i + j] * point[j];
  }
  return out;
}

Matrix inverse_of_rigid(const Matrix& matrix) {
  Matrix out = kIdentity;
  for (std::size_t i = 0; i < 3; ++i) {
    out[4 * i + 3] = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      out[4 * i + j] = matrix[4 * j + i];
      out[4 * i + 3] -= matrix[4 * j + i] * matrix[4 * j + 3];
    }
  }
  return out;
}

std::array<double, 3> first_voxel(const Header& header) {
  if (header.origin) return *header.origin;
  std::array<double, 3> first{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      first[row] -=
          header.direction[3 * row + axis] * header.spacing[axis] * (header.size[axis] - 1.0) / 2;
    }
  }
  return first;
}

Matrix between_indices(const Header& first, const Header& second, const Matrix& to_first) {
  return product(indices_of_points(second),
                 product(inverse_of_rigid(to_first), points_of_indices(first)));
}

Matrix indices_from_world(const Header& first, const Header& second, const Matrix& to_first) {
  const std::array<double, 3> middle{first.size[0] / 2.0, first.size[1] / 2.0, first.size[2] / 2.0};
  const std::array<double, 3> centre = moved(points_of_indices(first), middle);
  Matrix shift = kIdentity;
  for (std::size_t row = 0; row < 3; ++row) shift[4 * row + 3] = centre[row];
  return product(indices_of_points(second), product(inverse_of_rigid(to_first), shift));
}

}  // namespace diaphane::volume
