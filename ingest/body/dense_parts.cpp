#include "ingest/body/dense_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace diaphane::ingest {
namespace {

using volume::Label;

// Hounsfield units.
constexpr int kLeastBone = 200, kBoneSeed = 400;
constexpr int kLeastBlood = 100, kMostBlood = 650, kEvident = 150, kMostNoise = 240;
constexpr double kMostEvident = 480;
constexpr int kLeastVessel = 130, kRim = 150, kGasBeside = -300;
// Volumes in ml, distances in mm.
constexpr double kLeastPiece = 0.3, kLeastEvident = 1, kLeastSeeds = 0.05;
constexpr double kLeastFurther = 0.1;  // a vessel once contrast medium is evident
constexpr double kRimMm = 5, kBoneReach = 10, kVesselReach = 40, kMostMarrow = 60;
/// Shares of the surface of a piece: marrow is enclosed in a rim of denser bone, and gas is beside
/// contrast medium that was swallowed.
constexpr double kMostRim = 0.35, kMostGas = 0.05;

constexpr double kOneStep = 1e-6, kFar = 1e9;  // reach of a growth

/// A label outside of volume::Label, for contrast medium that is in no vessel.
constexpr std::uint8_t kOther = 255;
constexpr auto kBody = static_cast<std::uint8_t>(Label::kBody);
constexpr auto kBone = static_cast<std::uint8_t>(Label::kBone);
constexpr auto kVessel = static_cast<std::uint8_t>(Label::kVessel);

struct Contrast {
  CellMask vessels, others;  ///< smooth cells in vessels, and in the bowel
  double mean = 0;           ///< of the vessels; 0: no vessels are evident
  double densest = 0;        ///< greatest mean of a piece
};

/// What lies around a piece: shares of its surface.
struct Around {
  double rim = 0, gas = 0;
};

Around around(const CellValues& values, const CellMask& air, const CellList& piece,
              const CellMask& in_piece, double mean) {
  const Cells& cells = values.cells;
  const double dense = std::max<double>(mean + kRim, kBoneSeed - 50);
  std::array<std::ptrdiff_t, 3> stride{1, cells.size[0],
                                       static_cast<std::ptrdiff_t>(cells.level())};
  double faces = 0, rims = 0, gas = 0;
  for (const std::uint32_t cell : piece) {
    const auto place = cells.place(cell);
    for (std::size_t p = 0; p < 3; ++p) {
      const int reach = std::max(1, static_cast<int>(std::ceil(kRimMm / cells.mm[p])));
      for (const int sign : {-1, 1}) {
        bool is_face = false, is_rim = false, is_gas = false;
        for (int step = 1; step <= reach; ++step) {
          const int at = place[p] + sign * step;
          if (at < 0 || at >= cells.size[p]) break;
          const auto next = static_cast<std::size_t>(cell + sign * step * stride[p]);
          if (in_piece[next]) break;
          is_face = true;
          is_rim = is_rim || values.most[next] >= dense;
          is_gas = is_gas || (cells.mean[next] < kGasBeside && !air[next] && values.body[next]);
        }
        faces += is_face ? 1 : 0;
        rims += is_rim ? 1 : 0;
        gas += is_gas ? 1 : 0;
      }
    }
  }
  return {rims / std::max(1.0, faces), gas / std::max(1.0, faces)};
}

bool is_smooth(const CellValues& values, std::size_t cell) {
  const int least = values.least[cell], most = values.most[cell];
  return values.body[cell] && least >= kLeastBlood && most <= kMostBlood &&
         values.cells.mean[cell] >= kEvident && most - least <= kMostNoise;
}

/// Finds large pieces with an even value well above that of blood, such as the aorta.
Contrast find_contrast(const CellValues& values, const CellMask& air) {
  const Cells& cells = values.cells;
  CellMask smooth(cells.count());
  for (std::size_t i = 0; i < smooth.size(); ++i) smooth[i] = is_smooth(values, i) ? 1 : 0;
  Contrast contrast{CellMask(smooth.size()), CellMask(smooth.size()), 0, 0};
  double n = 0, sum = 0;
  bool is_evident = false;
  for (const CellList& piece : components(cells, smooth).members) {
    const double ml = static_cast<double>(piece.size()) * cells.cell_volume() / 1000;
    if (ml < kLeastFurther) continue;
    double mean = 0;
    for (const std::uint32_t cell : piece) mean += cells.mean[cell];
    const double total = mean;
    mean /= static_cast<double>(piece.size());
    const Around found = around(values, air, piece, smooth, mean);
    if (found.rim > kMostRim || mean > kMostEvident) continue;
    const bool is_bowel = found.gas > kMostGas;
    for (const std::uint32_t cell : piece)
      (is_bowel ? contrast.others : contrast.vessels)[cell] = 1;
    if (is_bowel) continue;
    is_evident = is_evident || ml >= kLeastEvident;
    n += static_cast<double>(piece.size());
    sum += total;
    contrast.densest = std::max(contrast.densest, mean);
  }
  if (!is_evident) contrast.vessels.assign(smooth.size(), 0);
  contrast.mean = is_evident ? sum / n : 0;
  return contrast;
}

/// One kind of voxels that grows from its seeds.
struct Growing {
  std::uint8_t label = 0;
  int low = 0, high = 0;  ///< values that it may take
  double reach = 0;       ///< mm
  std::vector<std::uint32_t> front{};
};

/// Grows several kinds at the same speed, so that each voxel gets the label of the nearest seed.
class Growth {
 public:
  Growth(const volume::Volume& volume, volume::Labels& labels)
      : volume_(volume), labels_(labels.voxels) {
    const auto& size = volume.header.size;
    for (std::size_t a = 0; a < 3; ++a) size_[a] = size[a];
    step_mm_ = *std::min_element(volume.header.spacing.begin(), volume.header.spacing.end());
  }

  void grow(std::vector<Growing>& kinds) {
    bool goes_on = true;
    for (double mm = 0; goes_on; mm += step_mm_) {
      goes_on = false;
      for (Growing& kind : kinds) {
        const std::vector<std::uint32_t> front = std::exchange(kind.front, {});
        if (mm >= kind.reach) continue;
        for (const std::uint32_t voxel : front) visit_neighbours(voxel, kind);
        goes_on = goes_on || !kind.front.empty();
      }
    }
  }

 private:
  void visit_neighbours(std::size_t voxel, Growing& kind) {
    const std::size_t x = voxel % size_[0], y = voxel / size_[0] % size_[1];
    const std::size_t area = size_[0] * size_[1], z = voxel / area;
    if (x > 0) visit(voxel - 1, kind);
    if (x + 1 < size_[0]) visit(voxel + 1, kind);
    if (y > 0) visit(voxel - size_[0], kind);
    if (y + 1 < size_[1]) visit(voxel + size_[0], kind);
    if (z > 0) visit(voxel - area, kind);
    if (z + 1 < size_[2]) visit(voxel + area, kind);
  }
  void visit(std::size_t voxel, Growing& kind) {
    const int value = volume_.voxels[voxel];
    if (labels_[voxel] != kBody || value < kind.low || value > kind.high) return;
    labels_[voxel] = kind.label;
    kind.front.push_back(static_cast<std::uint32_t>(voxel));
  }

  const volume::Volume& volume_;
  std::vector<std::uint8_t>& labels_;
  std::array<std::size_t, 3> size_{};
  double step_mm_ = 1;
};

/// Labels pieces of dense matter in a scan.
class DensePainter {
 public:
  DensePainter(const volume::Volume& volume, const CellValues& values, volume::Labels& labels)
      : volume_(volume), values_(values), labels_(labels) {
    const auto& spacing = volume.header.spacing;
    voxel_ml_ = spacing[0] * spacing[1] * spacing[2] / 1000;
  }

  void paint(const Contrast& contrast) {
    const bool has_vessels = contrast.mean > 0;
    const double step = 150;
    const int seed =
        has_vessels ? std::max(kBoneSeed, static_cast<int>(contrast.densest + step)) : kBoneSeed;
    const int blood = std::max(kLeastVessel, static_cast<int>(contrast.mean / 2));
    constexpr int kMost = std::numeric_limits<std::int16_t>::max();
    std::vector<Growing> kinds{{kBone, kLeastBone, kMost, has_vessels ? kBoneReach : kFar, {}},
                               {kVessel, blood, seed, kVesselReach, {}},
                               {kOther, kLeastVessel, kMost, kVesselReach, {}}};
    const CellMask bone =
        without_small(values_.cells, count_voxels([&](std::size_t i) {
                        return volume_.voxels[i] >= seed && labels_.voxels[i] == kBody;
                      }),
                      voxel_ml_, kLeastSeeds);
    // The edge of swallowed contrast medium is not a seed of bone, however dense it is.
    const CellMask near_others = dilated(values_.cells, contrast.others, {1, 1, 1});
    for_cell_runs(values_.cells, volume_.header.size,
                  [&](std::size_t cell, std::size_t voxel, std::size_t n) {
                    if (contrast.others[cell]) sow(voxel, n, kLeastVessel, kinds[2]);
                    if (contrast.vessels[cell]) sow(voxel, n, blood, kinds[1]);
                    if (bone[cell] && !near_others[cell]) sow(voxel, n, seed, kinds[0]);
                  });
    Growth(volume_, labels_).grow(kinds);
    drop_small(kBone);
    add_rim();
    fill_marrow();
    if (has_vessels) drop_small(kVessel);
    std::replace(labels_.voxels.begin(), labels_.voxels.end(), kOther, kBody);
  }

 private:
  template <typename Counts>
  std::vector<std::uint16_t> count_voxels(Counts counts) const {
    std::vector<std::uint16_t> voxels(values_.cells.count());
    for_cell_runs(values_.cells, volume_.header.size,
                  [&](std::size_t cell, std::size_t voxel, std::size_t n) {
                    int found = 0;
                    for (std::size_t i = voxel; i < voxel + n; ++i) found += counts(i) ? 1 : 0;
                    voxels[cell] = static_cast<std::uint16_t>(voxels[cell] + found);
                  });
    return voxels;
  }

  void sow(std::size_t voxel, std::size_t n, int least, Growing& kind) {
    for (std::size_t i = voxel; i < voxel + n; ++i) {
      if (labels_.voxels[i] != kBody || volume_.voxels[i] < least) continue;
      labels_.voxels[i] = kind.label;
      kind.front.push_back(static_cast<std::uint32_t>(i));
    }
  }

  std::vector<std::uint16_t> voxels_of(std::uint8_t label) const {
    return count_voxels([&](std::size_t i) { return labels_.voxels[i] == label; });
  }

  /// Removes the label from pieces that are too small, such as plaques.
  void drop_small(std::uint8_t label) {
    const CellMask kept = without_small(values_.cells, voxels_of(label), voxel_ml_, kLeastPiece);
    for_cell_runs(values_.cells, volume_.header.size,
                  [&](std::size_t cell, std::size_t voxel, std::size_t n) {
                    if (kept[cell]) return;
                    const auto first = labels_.voxels.begin() + static_cast<std::ptrdiff_t>(voxel);
                    std::replace(first, first + static_cast<std::ptrdiff_t>(n), label, kBody);
                  });
  }

  /// Adds the voxels that are bone in part beside dense bone. The surface of a picture often passes
  /// through them, so that it would have the colour of bone in some places only.
  void add_rim() {
    constexpr int kLeastRim = 100;
    std::vector<Growing> rim{{kBone, kLeastRim, kBoneSeed, kOneStep, {}}};
    for (std::size_t i = 0; i < labels_.voxels.size(); ++i) {
      if (labels_.voxels[i] != kBone || volume_.voxels[i] < kBoneSeed) continue;
      rim[0].front.push_back(static_cast<std::uint32_t>(i));
    }
    Growth(volume_, labels_).grow(rim);
  }

  void fill_marrow();

  const volume::Volume& volume_;
  const CellValues& values_;
  volume::Labels& labels_;
  double voxel_ml_ = 0;
};

/// Returns the cells that cannot be reached from the border of the grid without crossing `walls`.
CellMask enclosed_by(const Cells& cells, const CellMask& walls) {
  CellMask enclosed(walls.size());
  for (std::size_t i = 0; i < walls.size(); ++i) enclosed[i] = walls[i] ^ 1;
  std::vector<std::uint32_t> open;
  const auto visit = [&](std::size_t cell) {
    if (!enclosed[cell]) return;
    enclosed[cell] = 0;
    open.push_back(static_cast<std::uint32_t>(cell));
  };
  const auto inner = [&](const std::array<int, 3>& at, std::size_t p) {
    return at[p] > 0 && at[p] + 1 < cells.size[p];
  };
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const auto at = cells.place(i);
    if (!inner(at, 0) || !inner(at, 1) || !inner(at, 2)) visit(i);
  }
  const std::array<std::size_t, 3> stride{1, static_cast<std::size_t>(cells.size[0]),
                                          cells.level()};
  while (!open.empty()) {
    const std::size_t cell = open.back();
    open.pop_back();
    const auto at = cells.place(cell);
    for (std::size_t p = 0; p < 3; ++p) {
      if (at[p] > 0) visit(cell - stride[p]);
      if (at[p] + 1 < cells.size[p]) visit(cell + stride[p]);
    }
  }
  return enclosed;
}

/// Adds marrow: small spaces that bone encloses on all sides, but for gaps of a few mm. The
/// braincase is larger and open, and the cells of the mastoid hold air.
void DensePainter::fill_marrow() {
  constexpr int kLeastMarrow = -150, kMostOfMarrow = 400;
  const Cells& cells = values_.cells;
  const std::vector<std::uint16_t> bone = voxels_of(kBone);
  CellMask mask(bone.size());
  std::transform(bone.begin(), bone.end(), mask.begin(),
                 [](std::uint16_t n) { return n > 0 ? 1 : 0; });
  const CellMask closed = eroded(cells, dilated(cells, mask, {1, 1, 1}), {1, 1, 1});
  CellMask enclosed = enclosed_by(cells, closed), marrow(mask.size());
  const CellMask within = enclosed_by(cells, mask);  // the closed mask has no marrow in thin bones
  for (std::size_t i = 0; i < enclosed.size(); ++i) enclosed[i] |= within[i];
  for (const CellList& piece : components(cells, enclosed).members) {
    if (static_cast<double>(piece.size()) * cells.cell_volume() > 1000 * kMostMarrow) continue;
    double mean = 0;
    for (const std::uint32_t cell : piece) mean += cells.mean[cell];
    mean /= static_cast<double>(piece.size());
    if (mean < kLeastMarrow || mean > kMostOfMarrow) continue;
    for (const std::uint32_t cell : piece) marrow[cell] = 1;
  }
  marrow = dilated(cells, std::move(marrow), {1, 1, 1});
  for_cell_runs(cells, volume_.header.size,
                [&](std::size_t cell, std::size_t voxel, std::size_t n) {
                  if (!marrow[cell]) return;
                  for (std::size_t i = voxel; i < voxel + n; ++i) {
                    if (labels_.voxels[i] == kBody && volume_.voxels[i] >= kLeastMarrow)
                      labels_.voxels[i] = kBone;
                  }
                });
}

}  // namespace

void mark_dense_parts(const volume::Volume& volume, const CellValues& values, const CellMask& air,
                      volume::Labels& labels) {
  DensePainter(volume, values, labels).paint(find_contrast(values, air));
}

}  // namespace diaphane::ingest
