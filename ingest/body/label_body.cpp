#include "ingest/body/label_body.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "ingest/body/brain.h"
#include "ingest/body/decide.h"
#include "ingest/body/structures.h"

namespace diaphane::ingest {
namespace {

using volume::Label;

constexpr int kMetalHu = 2500;   // enamel, the densest tissue, rarely exceeds this
constexpr double kMarginMm = 1;  // margin of air that belongs to the body

/// How the voxels of a cell are labelled: all alike, or each by its value.
enum class Work : std::uint8_t { kAllOutside, kAllBody, kEachVoxel };

/// Labels voxels by the decision about their cells, slice by slice.
class Painter {
 public:
  Painter(const volume::Volume& volume, const Cells& cells, const ValueScale& scale,
          const Decision& decision)
      : volume_(volume),
        cells_(cells),
        scale_(scale),
        decision_(decision),
        metal_(scale.hounsfield && volume.header.maximum >= kMetalHu) {
    width_ = volume.header.size[0];
    height_ = volume.header.size[1];
    area_ = width_ * height_;
    for (std::size_t v = 0; v < 3; ++v) {
      margin_[v] =
          static_cast<std::size_t>(std::max(1.0, std::ceil(kMarginMm / volume.header.spacing[v])));
    }
    sort_cells();
  }

  volume::Labels paint() {
    const std::size_t depth = volume_.header.size[2], reach = margin_[2];
    volume::Labels labels{volume_.header.size, std::vector<std::uint8_t>(area_ * depth)};
    // A ring buffer of slices in which the body has grown by the margin within the slice.
    std::vector<std::vector<std::uint8_t>> ring(2 * reach + 1, std::vector<std::uint8_t>(area_));
    std::vector<std::uint8_t> grown(area_);
    for (std::size_t next = 0, z = 0; z < depth; ++z) {
      for (; next < std::min(depth, z + reach + 1); ++next) {
        mark_body(next, ring[next % ring.size()]);
      }
      const std::size_t first = z - std::min(z, reach), last = std::min(depth - 1, z + reach);
      grown = ring[first % ring.size()];
      for (std::size_t k = first + 1; k <= last; ++k) {
        or_into(grown.data(), ring[k % ring.size()].data(), area_);
      }
      label_slice(z, grown, labels.voxels.data() + z * area_);
    }
    return labels;
  }

 private:
  void sort_cells() {
    const auto& kinds = decision_.kinds;
    near_support_.resize(kinds.size());
    CellMask near_body(kinds.size());
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      near_support_[i] = kinds[i] == CellKind::kSupport || kinds[i] == CellKind::kCut;
      near_body[i] = kinds[i] != CellKind::kAir;
    }
    near_support_ = dilated(cells_, std::move(near_support_), {1, 1, 1});
    near_body = dilated(cells_, std::move(near_body), {1, 1, 1});
    work_.assign(kinds.size(), Work::kEachVoxel);
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      if (kinds[i] == CellKind::kInside && !metal_) work_[i] = Work::kAllBody;
      if (!near_body[i] && !near_support_[i] && !is_foam(i)) work_[i] = Work::kAllOutside;
    }
  }

  bool is_foam(std::size_t cell) const {
    return scale_.hounsfield && decision_.has_support && cells_.mean[cell] >= scale_.foam;
  }

  /// Calls `visit(cell, begin, end)` for each run of voxels of a row that lie in the same cell, or
  /// in cells whose voxels are all outside or all of the body.
  template <typename Visit>
  void for_runs(std::size_t y, std::size_t z, Visit visit) const {
    const std::size_t base = cells_.offsets[1][y] + cells_.offsets[2][z];
    const std::size_t* along = cells_.offsets[0].data();
    for (std::size_t x = 0; x < width_;) {
      const std::size_t begin = x, cell = base + along[x];
      const Work work = work_[cell];
      while (x < width_ && (along[x] == along[begin] ||
                            (work != Work::kEachVoxel && work_[base + along[x]] == work))) {
        ++x;
      }
      visit(cell, begin, x);
    }
  }

  /// Marks the voxels of the body in a slice, and grows them within the slice.
  void mark_body(std::size_t z, std::vector<std::uint8_t>& slice) {
    const std::int16_t* values = volume_.voxels.data() + z * area_;
    for (std::size_t y = 0; y < height_; ++y) {
      const std::size_t row = y * width_;
      for_runs(y, z, [&](std::size_t cell, std::size_t begin, std::size_t end) {
        const CellKind kind = decision_.kinds[cell];
        if (kind != CellKind::kSkin && kind != CellKind::kCut) {
          std::memset(slice.data() + row + begin, kind == CellKind::kInside ? 1 : 0, end - begin);
          return;
        }
        for (std::size_t x = begin; x < end; ++x) {
          const bool matter = values[row + x] >= scale_.matter;
          slice[row + x] = matter && (kind == CellKind::kSkin || in_front(x, y, z)) ? 1 : 0;
        }
      });
    }
    grow(slice);
  }

  void grow(std::vector<std::uint8_t>& slice) {
    scratch_ = slice;
    for (std::size_t by = 1; by <= margin_[0] && by < width_; ++by) {
      for (std::size_t row = 0; row < area_; row += width_) {
        or_into(slice.data() + row + by, scratch_.data() + row, width_ - by);
        or_into(slice.data() + row, scratch_.data() + row + by, width_ - by);
      }
    }
    scratch_ = slice;
    for (std::size_t by = 1; by <= margin_[1] && by < height_; ++by) {
      const std::size_t shift = by * width_;
      or_into(slice.data() + shift, scratch_.data(), area_ - shift);
      or_into(slice.data(), scratch_.data() + shift, area_ - shift);
    }
  }

  void label_slice(std::size_t z, const std::vector<std::uint8_t>& body, std::uint8_t* labels) {
    const std::int16_t* values = volume_.voxels.data() + z * area_;
    for (std::size_t y = 0; y < height_; ++y) {
      const std::size_t row = y * width_;
      for_runs(y, z, [&](std::size_t cell, std::size_t begin, std::size_t end) {
        if (work_[cell] != Work::kEachVoxel) {
          const Label label = work_[cell] == Work::kAllBody ? Label::kBody : Label::kOutside;
          std::memset(labels + row + begin, static_cast<int>(label), end - begin);
          return;
        }
        const bool foam = is_foam(cell);
        for (std::size_t x = begin; x < end; ++x) {
          const int value = values[row + x];
          const Label label = body[row + x] != 0 ? within_margin(cell, value, {x, y, z})
                              : near_support_[cell] != 0 || (foam && value >= scale_.foam)
                                  ? Label::kSupport
                                  : Label::kOutside;
          labels[row + x] = static_cast<std::uint8_t>(label);
        }
      });
    }
  }

  /// Returns the label of a voxel of the body or its margin. The margin stops at a support.
  Label within_margin(std::size_t cell, int value, const std::array<std::size_t, 3>& at) const {
    const CellKind kind = decision_.kinds[cell];
    if (value >= scale_.matter) {
      if (kind == CellKind::kSupport) return Label::kSupport;
      if (kind == CellKind::kCut && !in_front(at[0], at[1], at[2])) return Label::kSupport;
    }
    return metal_ && value >= kMetalHu ? Label::kMetal : Label::kBody;
  }

  bool in_front(std::size_t x, std::size_t y, std::size_t z) const {
    const std::array<std::size_t, 3> index{x, y, z};
    std::array<double, 3> place{};
    for (std::size_t p = 0; p < 3; ++p) {
      const std::size_t v = cells_.axis[p];
      const double i = static_cast<double>(index[v]) + 0.5;
      place[p] = (cells_.flipped[p] ? volume_.header.size[v] - i : i) * volume_.header.spacing[v];
    }
    return std::none_of(decision_.surfaces.begin(), decision_.surfaces.end(),
                        [&](const Surface& surface) { return surface.behind(place) > 0; });
  }

  const volume::Volume& volume_;
  const Cells& cells_;
  const ValueScale& scale_;
  const Decision& decision_;
  const bool metal_;
  std::size_t width_ = 0, height_ = 0, area_ = 0;
  std::array<std::size_t, 3> margin_{};
  CellMask near_support_;
  std::vector<Work> work_;
  std::vector<std::uint8_t> scratch_;
};

}  // namespace

volume::Labels label_body(const volume::Volume& volume) {
  if (volume.voxels.empty()) return {volume.header.size, {}};
  // All of a PET scan is body, because parts of the body with little uptake look like air.
  if (volume.header.modality == volume::Modality::kPt) {
    return {volume.header.size,
            std::vector(volume.voxels.size(), static_cast<std::uint8_t>(Label::kBody))};
  }
  const ValueScale scale = value_scale(volume);
  const Cells cells = make_cells(volume, scale.matter);
  const Decision decision = decide(volume, cells, scale);
  return Painter(volume, cells, scale, decision).paint();
}

namespace {

/// Adds what another phase shows of the patient, so that nothing that moves is hidden.
void add_body(const volume::Labels& phase, volume::Labels& labels) {
  using volume::is_body;
  for (std::size_t i = 0; i < labels.voxels.size(); ++i) {
    if (is_body(phase.voxels[i]) && !is_body(labels.voxels[i])) labels.voxels[i] = phase.voxels[i];
  }
}

void mark_parts(const volume::Volume& volume, volume::Labels& labels) {
  mark_brain(volume, labels);
  mark_structures(volume, labels);
}

}  // namespace

std::string found_labels(const volume::Volume& volume) {
  const std::size_t count = volume.header.voxel_count();
  if (volume.voxels.size() <= count) {
    volume::Labels labels = label_body(volume);
    mark_parts(volume, labels);
    return volume::encode(labels);
  }
  volume::Labels labels;
  volume::Volume phase;
  phase.header = volume.header;
  for (std::size_t at = 0; at + count <= volume.voxels.size(); at += count) {
    const auto begin = volume.voxels.begin() + static_cast<std::ptrdiff_t>(at);
    phase.voxels.assign(begin, begin + static_cast<std::ptrdiff_t>(count));
    volume::measure(phase);
    if (at == 0) {
      labels = label_body(phase);
      mark_parts(phase, labels);
    } else {
      add_body(label_body(phase), labels);
    }
  }
  return volume::encode(labels);
}

}  // namespace diaphane::ingest
