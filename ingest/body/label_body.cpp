#include "ingest/body/label_body.h"

#include <algorithm>
#include <cmath>

#include "ingest/body/decide.h"

namespace diaphane::ingest {
namespace {

using volume::Label;

constexpr int kMetalHu = 2500;    // enamel, the densest tissue, is rarely above
constexpr double kMarginMm = 1;   // of air that belongs to the body

/// Labels voxels by the decision about their cells, slice by slice.
class Painter {
 public:
  Painter(const volume::Volume& volume, const Cells& cells, const ValueScale& scale,
          const Decision& decision)
      : volume_(volume), cells_(cells), scale_(scale), decision_(decision) {
    const auto& size = volume.header.size;
    width_ = size[0];
    area_ = std::size_t{size[0]} * size[1];
    for (std::size_t v = 0; v < 3; ++v) {
      margin_[v] = std::max(1, static_cast<int>(std::ceil(kMarginMm / volume.header.spacing[v])));
    }
    near_support_.resize(decision.kinds.size());
    for (std::size_t i = 0; i < near_support_.size(); ++i) {
      near_support_[i] = decision.kinds[i] == CellKind::kSupport ||
                         decision.kinds[i] == CellKind::kCut;
    }
    near_support_ = dilated(cells, std::move(near_support_), {1, 1, 1});
  }

  volume::Labels paint() {
    const std::size_t depth = volume_.header.size[2];
    const auto reach = static_cast<std::size_t>(margin_[2]);
    volume::Labels labels{volume_.header.size, std::vector<std::uint8_t>(area_ * depth)};
    // Slices with the margin within the slice, in a ring.
    std::vector<std::vector<std::uint8_t>> ring(2 * reach + 1, std::vector<std::uint8_t>(area_));
    std::vector<std::uint8_t> grown(area_);
    for (std::size_t next = 0, z = 0; z < depth; ++z) {
      for (; next < std::min(depth, z + reach + 1); ++next) body_slice(next, ring[next % ring.size()]);
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
  /// Marks the voxels of the body in a slice, and grows them within the slice.
  void body_slice(std::size_t z, std::vector<std::uint8_t>& slice) {
    const std::int16_t* values = volume_.voxels.data() + z * area_;
    for (std::size_t y = 0; y < area_ / width_; ++y) {
      for_runs(y, z, [&](std::size_t cell, std::size_t begin, std::size_t end) {
        const CellKind kind = decision_.kinds[cell];
        const std::size_t row = y * width_;
        for (std::size_t x = begin; x < end; ++x) {
          bool body = kind == CellKind::kInside;
          if (kind == CellKind::kSkin) body = values[row + x] >= scale_.matter;
          if (kind == CellKind::kCut) {
            body = values[row + x] >= scale_.matter && in_front(x, y, z);
          }
          slice[row + x] = body ? 1 : 0;
        }
      });
    }
    grow(slice);
  }

  void grow(std::vector<std::uint8_t>& slice) {
    scratch_ = slice;
    for (std::size_t by = 1; by <= static_cast<std::size_t>(margin_[0]) && by < width_; ++by) {
      for (std::size_t row = 0; row < area_; row += width_) {
        or_into(slice.data() + row + by, scratch_.data() + row, width_ - by);
        or_into(slice.data() + row, scratch_.data() + row + by, width_ - by);
      }
    }
    scratch_ = slice;
    for (std::size_t by = 1; by <= static_cast<std::size_t>(margin_[1]); ++by) {
      const std::size_t shift = by * width_;
      if (shift >= area_) break;
      or_into(slice.data() + shift, scratch_.data(), area_ - shift);
      or_into(slice.data(), scratch_.data() + shift, area_ - shift);
    }
  }

  void label_slice(std::size_t z, const std::vector<std::uint8_t>& body, std::uint8_t* labels) {
    const std::int16_t* values = volume_.voxels.data() + z * area_;
    for (std::size_t y = 0; y < area_ / width_; ++y) {
      for_runs(y, z, [&](std::size_t cell, std::size_t begin, std::size_t end) {
        const CellKind kind = decision_.kinds[cell];
        const bool support = near_support_[cell] != 0;
        const bool foam = scale_.hounsfield && cells_.mean[cell] >= scale_.foam;
        for (std::size_t i = y * width_ + begin; i < y * width_ + end; ++i) {
          labels[i] = static_cast<std::uint8_t>(
              label_of(kind, support, foam, body[i] != 0, values[i], i - y * width_, y, z));
        }
      });
    }
  }

  Label label_of(CellKind kind, bool near_support, bool foam, bool body, int value, std::size_t x,
                 std::size_t y, std::size_t z) const {
    if (body && value >= scale_.matter) {
      // The margin does not reach into a support.
      if (kind == CellKind::kSupport) return Label::kSupport;
      if (kind == CellKind::kCut && !in_front(x, y, z)) return Label::kSupport;
    }
    if (body) return scale_.hounsfield && value >= kMetalHu ? Label::kMetal : Label::kBody;
    if (near_support) return Label::kSupport;
    return foam && value >= scale_.foam ? Label::kSupport : Label::kOutside;
  }

  /// Calls `visit(cell, begin, end)` for each run of voxels of a row that lie in the same cell.
  template <typename Visit>
  void for_runs(std::size_t y, std::size_t z, Visit visit) const {
    const std::size_t base = cells_.offsets[1][y] + cells_.offsets[2][z];
    const std::size_t* along = cells_.offsets[0].data();
    for (std::size_t x = 0; x < width_;) {
      const std::size_t begin = x;
      while (x < width_ && along[x] == along[begin]) ++x;
      visit(base + along[begin], begin, x);
    }
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
  std::size_t width_ = 0, area_ = 0;
  std::array<int, 3> margin_{};
  CellMask near_support_;
  std::vector<std::uint8_t> scratch_;
};

}  // namespace

volume::Labels label_body(const volume::Volume& volume) {
  if (volume.voxels.empty()) return {volume.header.size, {}};
  const ValueScale scale = value_scale(volume);
  const Cells cells = make_cells(volume, scale.matter);
  return Painter(volume, cells, scale, decide(volume, cells, scale)).paint();
}

}  // namespace diaphane::ingest
