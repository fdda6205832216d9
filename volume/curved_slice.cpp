#include "volume/curved_slice.h"

#include <cmath>
#include <numbers>
#include <span>

namespace diaphane::volume {
namespace {

/// Tolerance in pixels for the length of a curve, which pages compute themselves.
constexpr double kRounding = 1e-6;

/// Joins columns, which `read` returns for a column and its number, to rows.
template <typename Value, typename Read>
std::vector<Value> joined(const CurvedSlice& slice, const Read& read) {
  std::vector<Value> values(std::size_t{slice.columns} * slice.rows);
  std::size_t column = 0;
  for (const ObliqueSlice& one : columns_of(slice)) {
    const std::vector<Value> pixels = read(one, column);
    for (std::size_t row = 0; row < slice.rows; ++row) {
      values[row * slice.columns + column] = pixels[row];
    }
    ++column;
  }
  return values;
}

std::vector<std::int16_t> column_of(const CurvedSlice& slice, std::span<const std::int16_t> values,
                                    std::size_t column) {
  std::vector<std::int16_t> pixels;
  for (std::size_t row = 0; row < slice.rows; ++row) {
    pixels.push_back(values[row * slice.columns + column]);
  }
  return pixels;
}

}  // namespace

Result<void> check(const Header& header, const CurvedSlice& slice) {
  const auto refuse = [](const char* field) {
    return fail(ErrorCode::kInvalid, "This curved slice is not valid.", field);
  };
  const auto curve = Curve::through(slice.points);
  if (!curve) return tl::unexpected(curve.error());
  if (!std::isfinite(slice.angle)) return refuse("angle");
  if (!(slice.pixel > 0)) return refuse("pixel");
  // The limits of pixels and samples are those of oblique slices.
  ObliqueSlice flat;
  flat.columns = slice.columns;
  flat.rows = slice.rows;
  flat.right = {slice.pixel, 0, 0};
  flat.down = {0, slice.pixel, 0};
  flat.thickness = slice.thickness;
  if (const auto checked = check(header, flat); !checked) {
    return checked.error().field == "right" ? refuse("pixel") : checked;
  }
  if (slice.columns - 1 > curve->length() / slice.pixel + kRounding) return refuse("columns");
  return {};
}

std::uint32_t columns_along(const std::vector<Vector>& points, double pixel) {
  const auto curve = Curve::through(points);
  if (!curve || !(pixel > 0)) return 0;
  const double steps = std::floor(curve->length() / pixel + kRounding);
  return steps < kMostObliqueSide ? static_cast<std::uint32_t>(steps) + 1 : 0;
}

std::uint64_t samples_of(const Header& header, const CurvedSlice& slice) {
  return std::uint64_t{slice.columns} * slice.rows * layers_of(header, slice.thickness);
}

std::vector<ObliqueSlice> columns_of(const CurvedSlice& slice) {
  const Curve curve = *Curve::through(slice.points);
  const double angle = slice.angle * std::numbers::pi / 180;
  std::vector<ObliqueSlice> columns;
  for (std::uint32_t column = 0; column < slice.columns; ++column) {
    const auto [place, along, across] = curve.at(column * slice.pixel);
    const Vector third{along[1] * across[2] - along[2] * across[1],
                       along[2] * across[0] - along[0] * across[2],
                       along[0] * across[1] - along[1] * across[0]};
    ObliqueSlice one;
    one.columns = 1;
    one.rows = slice.rows;
    for (std::size_t k = 0; k < 3; ++k) {
      one.right[k] = slice.pixel * along[k];
      one.down[k] = slice.pixel * (std::cos(angle) * across[k] + std::sin(angle) * third[k]);
      one.first[k] = place[k] - (slice.rows - 1) / 2.0 * one.down[k];
    }
    one.thickness = slice.thickness;
    one.projection = slice.projection;
    columns.push_back(one);
  }
  return columns;
}

std::vector<std::int16_t> sample(const Volume& volume, const CurvedSlice& slice) {
  return joined<std::int16_t>(
      slice, [&](const ObliqueSlice& one, std::size_t) { return sample(volume, one); });
}

std::vector<std::int16_t> sample_clipped(const Volume& volume, const CurvedSlice& slice,
                                         const KeptVoxels& kept) {
  return joined<std::int16_t>(slice, [&](const ObliqueSlice& one, std::size_t) {
    return sample_clipped(volume, one, kept);
  });
}

std::vector<std::uint8_t> labels_of_slice(const Volume& volume, const CurvedSlice& slice,
                                          const ClippedSlice* clipped) {
  return joined<std::uint8_t>(slice, [&](const ObliqueSlice& one, std::size_t column) {
    if (!clipped) return labels_of_slice(volume, one);
    const auto values = column_of(slice, clipped->values, column);
    const ClippedSlice part{clipped->kept, values};
    return labels_of_slice(volume, one, &part);
  });
}

std::vector<std::int16_t> second_slice(const Header& first, const CurvedSlice& slice,
                                       const Volume& second, const Matrix& to_first,
                                       std::span<const std::int16_t> shown) {
  return joined<std::int16_t>(slice, [&](const ObliqueSlice& one, std::size_t column) {
    return second_slice(first, pixels_of(one), second, to_first, column_of(slice, shown, column));
  });
}

}  // namespace diaphane::volume
