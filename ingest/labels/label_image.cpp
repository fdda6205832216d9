#include "ingest/labels/label_image.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "common/try.h"
#include "volume/frame_of_reference.h"

namespace diaphane::ingest {
namespace {

using Vec = std::array<double, 3>;
using Matrix = std::array<double, 9>;  // row-major

tl::unexpected<Error> other_scan(const char* why) {
  return fail(ErrorCode::kInvalid,
              std::string("These labels do not belong to this scan: ") + why + ".", kOtherScan);
}

Vec times(const Matrix& m, const Vec& v) {
  Vec out{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t i = 0; i < 3; ++i) out[row] += m[3 * row + i] * v[i];
  }
  return out;
}

Matrix times(const Matrix& a, const Matrix& b) {
  Matrix out{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      for (std::size_t i = 0; i < 3; ++i) {
        out[3 * row + column] += a[3 * row + i] * b[3 * i + column];
      }
    }
  }
  return out;
}

/// Returns the inverse, or nullopt for a singular matrix.
std::optional<Matrix> inverse(const Matrix& m) {
  const auto minor = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
    return m[a] * m[d] - m[b] * m[c];
  };
  const double determinant =
      m[0] * minor(4, 5, 7, 8) - m[1] * minor(3, 5, 6, 8) + m[2] * minor(3, 4, 6, 7);
  // The negated comparison also rejects NaN.
  if (!(std::abs(determinant) > 1e-12)) return std::nullopt;
  const double s = 1 / determinant;
  return Matrix{s * minor(4, 5, 7, 8), s * minor(2, 1, 8, 7), s * minor(1, 2, 4, 5),
                s * minor(5, 3, 8, 6), s * minor(0, 2, 6, 8), s * minor(2, 0, 5, 3),
                s * minor(3, 4, 6, 7), s * minor(1, 0, 7, 6), s * minor(0, 1, 3, 4)};
}

Matrix axes_of(const volume::Header& scan) {
  Matrix axes{};
  for (std::size_t i = 0; i < 9; ++i) axes[i] = scan.direction[i] * scan.spacing[i % 3];
  return axes;
}

/// Returns the middle of a box relative to the centre of its first voxel.
Vec middle_of(const Matrix& axes, const std::array<std::uint32_t, 3>& size) {
  return times(axes, Vec{(size[0] - 1.0) / 2, (size[1] - 1.0) / 2, (size[2] - 1.0) / 2});
}

/// Returns whether two grids are the same up to the order and direction of their axes. `turn` maps
/// steps of `from` to steps of `to`.
bool is_same_grid(const Matrix& turn, const std::array<std::uint32_t, 3>& from,
                  const std::array<std::uint32_t, 3>& to) {
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      constexpr double kTolerance = 0.01;
      const double step = std::abs(turn[3 * row + column]);
      const bool along = std::abs(step - 1) < kTolerance;
      if (along && from[column] != to[row]) return false;
      if (!along && !(step < kTolerance)) return false;
    }
  }
  return true;
}

/// Maps voxels of a scan to the grid of a label image.
struct Mapping {
  Matrix turn{};  ///< from steps of the scan to steps of the image
  Vec start{};    ///< position of the scan's first voxel
};

Result<Mapping> mapping_of(const LabelImage& image, const volume::Header& scan) {
  const Matrix axes = axes_of(scan);
  const auto back = inverse(image.axes);
  if (!back) return fail(ErrorCode::kInvalid, "The labels have no valid orientation.");
  Mapping mapping;
  mapping.turn = times(*back, axes);
  Vec between{};
  if (image.origin && scan.origin) {
    for (std::size_t i = 0; i < 3; ++i) between[i] = (*scan.origin)[i] - (*image.origin)[i];
  } else {
    if (!is_same_grid(mapping.turn, scan.size, image.size)) {
      return other_scan(
          "their voxels are not those of the scan, and one of the two does not say where it lies "
          "in the patient");
    }
    const Vec mine = middle_of(axes, scan.size), theirs = middle_of(image.axes, image.size);
    for (std::size_t i = 0; i < 3; ++i) between[i] = theirs[i] - mine[i];
  }
  mapping.start = times(*back, between);
  for (const double v : mapping.start) {
    if (!std::isfinite(v)) return other_scan("they lie elsewhere");
  }
  return mapping;
}

/// Fills one row of voxels and returns whether it has any label.
bool fill_row(const LabelImage& image, const Mapping& mapping, Vec at, std::uint32_t count,
              std::uint8_t* to) {
  const Vec step{mapping.turn[0], mapping.turn[3], mapping.turn[6]};
  const auto& size = image.size;
  std::uint8_t any = 0;
  for (std::uint32_t x = 0; x < count; ++x) {
    std::array<std::int64_t, 3> index{};
    bool inside = true;
    for (std::size_t i = 0; i < 3; ++i) {
      const double place = std::floor(at[i] + x * step[i] + 0.5);
      inside = inside && place >= 0 && place < size[i];
      index[i] = inside ? static_cast<std::int64_t>(place) : 0;
    }
    if (inside) {
      to[x] = image.voxels[static_cast<std::size_t>(
          index[0] + std::int64_t{size[0]} * (index[1] + std::int64_t{size[1]} * index[2]))];
    }
    any |= to[x];
  }
  return any != 0;
}

}  // namespace

Result<void> check_frame_of_reference(const std::string& labels, const volume::Header& scan) {
  const std::string& own = scan.frame_of_reference;  // the UID itself while a scan is built
  if (labels == own || volume::is_frame_of_reference(own, labels)) return {};
  return other_scan("they use another frame of reference");
}

Result<volume::LabelSet> place_labels(LabelImage image, const volume::Header& scan) {
  DIAPHANE_TRY(check_frame_of_reference(image.frame_of_reference, scan));
  const auto mapping = mapping_of(image, scan);
  DIAPHANE_TRY(mapping);
  volume::LabelSet set;
  set.table = std::move(image.table);
  set.labels.size = scan.size;
  try {
    set.labels.voxels.resize(scan.voxel_count());
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "The labels need more memory than allowed.");
  }
  bool any = false;
  std::uint8_t* row = set.labels.voxels.data();
  for (std::uint32_t z = 0; z < scan.size[2]; ++z) {
    for (std::uint32_t y = 0; y < scan.size[1]; ++y, row += scan.size[0]) {
      Vec at = times(mapping->turn, Vec{0, static_cast<double>(y), static_cast<double>(z)});
      for (std::size_t i = 0; i < 3; ++i) at[i] += mapping->start[i];
      any = fill_row(image, *mapping, at, scan.size[0], row) || any;
    }
  }
  if (!any) return other_scan("none of them overlaps it");
  return set;
}

}  // namespace diaphane::ingest
