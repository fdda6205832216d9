#include "renderd/scene/overlay.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderd/kernel/overlay.h"

namespace diaphane::render {
namespace {

constexpr double kLayer = 100;  ///< mm

AffineMap map_of(const volume::Matrix& m) {
  AffineMap map{};
  for (std::size_t i = 0; i < 3; ++i) {
    map.rows[i] = to_float(Double3{m[4 * i], m[4 * i + 1], m[4 * i + 2]});
  }
  map.shift = to_float(Double3{m[3], m[7], m[11]});
  return map;
}

void bound_cells(const PreparedTransfer& first, const std::vector<CellBounds>& bounds,
                 Float3 spacing, Int3 size, PreparedOverlay& out) {
  const PreparedTransfer& second = *out.transfer;
  if (bounds.empty() || second.bounds.empty()) return;
  const MatterShares<true> shares{out.view.first_share, out.view.second_share};
  out.majorants.reserve(bounds.size());
  out.bounds.reserve(bounds.size());
  for (std::int32_t z = 0; z < first.cells.z; ++z) {
    for (std::int32_t y = 0; y < first.cells.y; ++y) {
      for (std::int32_t x = 0; x < first.cells.x; ++x) {
        const CellBounds of_second =
            second_bounds(out.view.map, {x, y, z}, second.bounds.data(), second.cells, out.size);
        out.majorants.push_back(of_second.majorant);
        out.bounds.push_back(
            mixed_bounds(bounds[out.bounds.size()], of_second, out.view.split, shares));
      }
    }
  }
  out.steep = is_steep(out.bounds, spacing);
  out.occupied = occupied_box(out.bounds, first.cells, size);
}

}  // namespace

float surfaces_of(const diaphane::v1::Shading& shading, double densest) {
  constexpr double kUsualScale = 0.1;
  switch (shading.mode()) {
    case diaphane::v1::Shading::SURFACE:
      return std::numeric_limits<float>::infinity();
    case diaphane::v1::Shading::HYBRID: {
      const double given = shading.gradient_scale();
      const double scale = (given > 0 ? given : kUsualScale);
      return static_cast<float>(std::min(1 / (scale * std::max(densest, 1e-30)), 1e38));
    }
    default:
      return 0;
  }
}

double extinction_share(double keep, double densest) {
  if (keep >= 1) return 1;
  if (keep <= 0) return 0;
  const double depth = densest * kLayer;
  return depth > 0 ? -std::log1p(keep * std::expm1(-depth)) / depth : keep;
}

std::shared_ptr<const PreparedOverlay> prepare_overlay(const diaphane::v1::Scene& scene,
                                                       const PreparedTransfer& first,
                                                       const std::vector<CellBounds>& bounds,
                                                       const volume::Header& header,
                                                       std::uint32_t width,
                                                       const SecondScan& second) {
  const auto& overlay = scene.overlay();
  const bool split = overlay.mode() == diaphane::v1::Overlay::SPLIT;
  if (!overlay.has_transfer_function() || (!split && !(overlay.share() > 0))) return nullptr;
  auto out = std::make_shared<PreparedOverlay>();
  const volume::Header& h = second.header;
  const Float3 spacing = to_float(Double3{h.spacing[0], h.spacing[1], h.spacing[2]});
  out->size = size_of(h);
  out->transfer =
      second.baked != nullptr
          ? second.baked->get(overlay.transfer_function(), second.grid, out->size, spacing)
          : std::make_shared<const PreparedTransfer>(
                prepare_transfer(overlay.transfer_function(), second.grid, out->size, spacing));
  const double first_kept = std::min(1.0, 2 - 2 * overlay.share());
  const double second_kept = std::min(1.0, 2 * overlay.share());
  const double densest = overlay.transfer_function().extinction_per_mm();
  OverlayView<LinearVolume>& view = out->view;
  view.map = map_of(volume::between_indices(header, h, second.to_first));
  view.step = std::min({spacing.x, spacing.y, spacing.z});
  view.surfaces = surfaces_of(scene.shading(), densest);
  view.per_extinction = densest > 0 ? static_cast<float>(1 / densest) : 0.0F;
  view.first_share = static_cast<float>(extinction_share(first_kept, first.densest));
  view.second_share = static_cast<float>(extinction_share(second_kept, out->transfer->densest));
  view.first_in_slices = static_cast<float>(first_kept);
  view.second_in_slices = static_cast<float>(second_kept);
  view.split = split;
  view.split_column = static_cast<float>(overlay.split() * width);
  bound_cells(first, bounds,
              to_float(Double3{header.spacing[0], header.spacing[1], header.spacing[2]}),
              size_of(header), *out);
  return out;
}

}  // namespace diaphane::render
