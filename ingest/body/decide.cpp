#include "ingest/body/decide.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace diaphane::ingest {
namespace {

// Radius of the opening. Shells of tables and headrests, bars and straps are thinner than twice
// this; the trunk, limbs and the head are thicker.
constexpr double kOpeningMm = 4.5;
constexpr int kRegrownCells = 2;  // growth that restores the rounded edges lost to the opening
constexpr double kLimbCm3 = 20;   // minimum volume of a separate body part
constexpr double kTouchMm = 4;
constexpr double kNearMm = 15;      // ears, nose and fingers are this close to thicker parts
constexpr double kLongMm = 80;      // thin parts of a body are shorter
constexpr double kWideMm = 100;     // shells are wider
constexpr double kLeastCore = 0.4;  // minimum share of the matter; below, the body itself is thin
constexpr double kMostShellMm = 6.5;
constexpr double kMostCutMm = 15;  // maximum mean thickness that a surface cuts from the body
constexpr double kSpeckCm3 = 0.2;  // connected noise has less volume than this

using Members = CellList;

struct Extent {
  std::array<int, 3> low{1 << 30, 1 << 30, 1 << 30}, high{-1, -1, -1};
  double mm(const Cells& cells, std::size_t p) const {
    return (high[p] - low[p] + 1) * cells.mm[p];
  }
  double longest(const Cells& cells) const {
    return std::max({mm(cells, 0), mm(cells, 1), mm(cells, 2)});
  }
};

Extent extent_of(const Cells& cells, const Members& members) {
  Extent extent;
  for (const std::size_t cell : members) {
    const auto at = cells.place(cell);
    for (std::size_t p = 0; p < 3; ++p) {
      extent.low[p] = std::min(extent.low[p], at[p]);
      extent.high[p] = std::max(extent.high[p], at[p]);
    }
  }
  return extent;
}

std::array<double, 3> middle_of_all(const Cells& cells, const Members& members) {
  std::array<double, 3> sum{};
  for (const std::size_t cell : members) {
    const auto at = middle_of(cells, cells.place(cell));
    for (std::size_t p = 0; p < 3; ++p) sum[p] += at[p];
  }
  for (double& s : sum) s /= std::max<double>(1, static_cast<double>(members.size()));
  return sum;
}

double share_in(const CellMask& mask, const Members& members) {
  std::size_t n = 0;
  for (const std::size_t cell : members) n += mask[cell];
  return static_cast<double>(n) / static_cast<double>(members.size());
}

/// Returns how well a component continues `levels` further along the patient if it is moved by
/// (dx, dy), with a tolerance of one cell.
double continuation(const Cells& cells, const Components& all, const Members& members,
                    const Extent& extent, int levels, int dx, int dy) {
  const std::int32_t label = all.label[members.front()];
  const auto is_member = [&](int x, int y, int z) {
    for (int b = std::max(0, y - 1); b <= std::min(cells.size[1] - 1, y + 1); ++b) {
      for (int a = std::max(0, x - 1); a <= std::min(cells.size[0] - 1, x + 1); ++a) {
        if (all.label[cells.at(a, b, z)] == label) return true;
      }
    }
    return false;
  };
  std::size_t asked = 0, found = 0;
  const std::size_t step = members.size() / 1500 + 1;
  for (std::size_t i = 0; i < members.size(); i += step) {
    const auto [x, y, z] = cells.place(members[i]);
    const bool inside =
        x + dx >= 0 && x + dx < cells.size[0] && y + dy >= 0 && y + dy < cells.size[1];
    if (!inside || z + levels > extent.high[2]) continue;
    ++asked;
    found += is_member(x + dx, y + dy, z + levels) ? 1 : 0;
  }
  return asked == 0 ? 0 : static_cast<double>(found) / static_cast<double>(asked);
}

/// Returns whether a component has nearly the same cross-section all along the patient, as tables
/// and headrests have, even in a tilted scan.
bool is_straight(const Cells& cells, const Components& all, const Members& members) {
  constexpr double kLeastAlongMm = 30, kStepMm = 15, kShare = 0.9;
  const Extent extent = extent_of(cells, members);
  const double height = cells.size[2] * cells.mm[2];
  if (extent.mm(cells, 2) < std::min(kLeastAlongMm, 0.9 * height)) return false;
  const int levels = std::max(1, static_cast<int>(std::lround(kStepMm / cells.mm[2])));
  if (levels >= extent.high[2] - extent.low[2]) return false;
  for (int dy = -3; dy <= 3; ++dy) {
    for (int dx = -2; dx <= 2; ++dx) {
      if (continuation(cells, all, members, extent, levels, dx, dy) >= kShare) return true;
    }
  }
  return false;
}

/// Returns whether a component is a wide slab, such as a table that is filled with dense foam.
bool is_slab(const Cells& cells, const Components& all, const Members& members) {
  const Extent extent = extent_of(cells, members);
  const double x = extent.mm(cells, 0), y = extent.mm(cells, 1);
  const bool flat = std::max(x, y) >= 200 && std::max(x, y) >= 4 * std::min(x, y);
  return flat && is_straight(cells, all, members);
}

class Decider {
 public:
  Decider(const volume::Volume& volume, const Cells& cells, const ValueScale& scale)
      : volume_(volume), cells_(cells), scale_(scale) {}

  Decision decide() {
    find_matter();
    find_core();
    body_ = grown_within(cells_, core_, matter_, kRegrownCells);
    support_.assign(cells_.count(), 0);
    sort_out_rest();
    return kinds();
  }

 private:
  void find_matter() {
    // Noise puts single voxels above the threshold.
    const std::uint8_t least = scale_.hounsfield ? 1 : 2;
    matter_.resize(cells_.count());
    for (std::size_t i = 0; i < matter_.size(); ++i) matter_[i] = cells_.matter[i] >= least;
  }

  /// Finds the core of the body by a morphological opening of the matter.
  void find_core() {
    const auto radius = cells_.radius(kOpeningMm);
    // In MR, the skin is a thin shell around the dark skull. CT has no such gaps unless its skin
    // was removed, but it has hollow tables, which are not to be filled.
    const std::size_t all = count(matter_);
    if (scale_.density) open(matter_, radius);
    if (!scale_.density || count(core_) < kLeastCore * static_cast<double>(all)) {
      open(filled(cells_, matter_, Border::kOpen), radius);
    }
    has_core_ = all > 0 && count(core_) >= kLeastCore / 2 * static_cast<double>(all);
    const CellMask& bulk = has_core_ ? core_ : matter_;
    for (std::size_t i = 0; i < bulk.size(); ++i) {
      if (bulk[i]) bulk_.push_back(static_cast<std::uint32_t>(i));
    }
    bulk_middle_ = middle_of_all(cells_, bulk_);
  }

  void open(const CellMask& solid, const std::array<int, 3>& radius) {
    const Components parts = components(cells_, eroded(cells_, solid, radius));
    CellMask seeds(cells_.count(), 0);
    for (const Members& part : parts.members) {
      if (is_slab(cells_, parts, part)) continue;
      for (const std::size_t cell : part) seeds[cell] = 1;
    }
    const CellMask opened = dilated(cells_, seeds, radius);
    take_body_parts(components(cells_, opened));
  }

  double cm3(const Members& part) const {
    return static_cast<double>(part.size()) * cells_.cell_volume() / 1000;
  }

  /// Takes as the core the largest part, all parts that are large enough for a limb, and smaller
  /// parts next to these, such as fingers.
  void take_body_parts(const Components& wide) {
    std::size_t most = 0;
    for (const Members& part : wide.members) most = std::max(most, part.size());
    core_.assign(cells_.count(), 0);
    CellMask near;
    for (const bool small : {false, true}) {
      for (const Members& part : wide.members) {
        if (small != (part.size() < most && cm3(part) < kLimbCm3)) continue;
        if (small && share_in(near, part) == 0) continue;
        for (const std::size_t cell : part) core_[cell] = matter_[cell];
      }
      if (!small) near = dilated(cells_, core_, cells_.radius(kTouchMm));
    }
  }

  /// Assigns the matter that the opening removed to the body or to a support.
  void sort_out_rest() {
    CellMask rest = matter_;
    for (std::size_t i = 0; i < rest.size(); ++i) rest[i] = matter_[i] && !body_[i];
    const Components parts = components(cells_, rest);
    const CellMask near = dilated(cells_, body_, cells_.radius(kNearMm));
    std::vector<const Members*> doubtful;
    Members supports;
    for (const Members& part : parts.members) {
      const Place placed = place_of(parts, part, near);
      if (placed == Place::kNowhere) continue;
      if (placed == Place::kDoubtful) {
        doubtful.push_back(&part);
        continue;
      }
      assign(part, placed == Place::kSupport, supports);
    }
    const std::array<double, 2> down = side_of(supports);
    for (const Members* part : doubtful) assign(*part, is_shell(*part, down), supports);
    // All supports together show most of a surface. If it cannot be fitted, each is tried
    // separately.
    if (supports.empty() || cut_behind(supports)) return;
    for (const Members& part : components(cells_, support_).members) cut_behind(part);
  }

  void assign(const Members& part, bool support, Members& supports) {
    for (const std::size_t cell : part) (support ? support_ : body_)[cell] = 1;
    if (support) supports.insert(supports.end(), part.begin(), part.end());
  }

  enum class Place { kNowhere, kBody, kSupport, kDoubtful };

  Place place_of(const Components& parts, const Members& part, const CellMask& near) const {
    const double outside = 1 - share_in(near, part);
    if (scale_.noisy && cm3(part) < kSpeckCm3) return Place::kNowhere;
    const Extent extent = extent_of(cells_, part);
    // Without a core to compare with, only a wide shell is a support, because vessels are long too.
    const bool is_long = has_core_
                             ? extent.longest(cells_) >= kLongMm
                             : std::max(extent.mm(cells_, 0), extent.mm(cells_, 1)) >= kWideMm;
    if (has_core_ && !is_long) return outside > 0.9 ? Place::kSupport : Place::kBody;
    if (has_core_ && outside >= 0.5) return Place::kSupport;
    return is_long && is_straight(cells_, parts, part) ? Place::kDoubtful : Place::kBody;
  }

  /// Returns the direction from the body to its supports, or to the back if there are none yet.
  std::array<double, 2> side_of(const Members& supports) const {
    if (supports.empty()) return {0, 1};
    const auto middle = middle_of_all(cells_, supports), body = bulk_middle_;
    const double x = middle[0] - body[0], y = middle[1] - body[1];
    const double length = std::hypot(x, y);
    return length < 20 ? std::array<double, 2>{0, 1}
                       : std::array<double, 2>{x / length, y / length};
  }

  /// Returns whether a straight part close to the body is the shell that the body lies on, rather
  /// than a thin wall of the body.
  bool is_shell(const Members& part, const std::array<double, 2>& down) const {
    if (thickness(part) > kMostShellMm) return false;
    const auto along = [&](const std::array<double, 3>& at) {
      return at[0] * down[0] + at[1] * down[1];
    };
    const double middle = along(bulk_middle_);
    double most = middle;
    for (const std::size_t cell : bulk_) {
      most = std::max(most, along(middle_of(cells_, cells_.place(cell))));
    }
    return along(middle_of_all(cells_, part)) > middle + 0.5 * (most - middle);
  }

  /// Returns the thickness of a part in mm: the median of the shortest path through matter per
  /// cell.
  double thickness(const Members& part) const {
    std::vector<double> ways;
    for (std::size_t i = 0; i < part.size(); i += part.size() / 1000 + 1) {
      double least = 1e9;
      for (std::size_t axis = 0; axis < 3; ++axis) least = std::min(least, way(part[i], axis));
      ways.push_back(least);
    }
    const auto median = ways.begin() + static_cast<std::ptrdiff_t>(ways.size() / 2);
    std::nth_element(ways.begin(), median, ways.end());
    return *median;
  }

  double way(std::size_t cell, std::size_t axis) const {
    double eighths = cells_.matter[cell];
    for (const int step : {-1, 1}) {
      auto at = cells_.place(cell);
      for (int i = 0; i < 8; ++i) {
        at[axis] += step;
        if (at[axis] < 0 || at[axis] >= cells_.size[axis]) break;
        const std::uint8_t matter = cells_.matter[cells_.at(at[0], at[1], at[2])];
        if (matter == 0) break;
        eighths += matter;
      }
    }
    return eighths / 8 * cells_.mm[axis];
  }

  /// Moves thick parts in front of the surface that touch the body, such as fingers, back to it.
  void rescue_before(const Surface& surface) {
    const CellsBehind behind(surface, cells_);
    CellMask before(cells_.count(), 0);
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (!support_[i]) continue;
      const double by = behind(cells_.place(i));
      before[i] = std::isfinite(by) && by < -cells_.mm[surface.deep] / 2;
    }
    const Components parts = components(cells_, before);
    const CellMask near = dilated(cells_, body_, cells_.radius(kTouchMm));
    for (const Members& part : parts.members) {
      if (share_in(near, part) == 0 || thickness(part) <= kMostShellMm) continue;
      for (const std::size_t cell : part) {
        support_[cell] = 0;
        body_[cell] = 1;
      }
    }
  }

  /// Moves the part of the body that lies behind the support's surface to the support. Returns
  /// false if no surface can be fitted.
  bool cut_behind(const Members& part) {
    const auto surface = fit_surface(volume_, cells_, scale_.matter, part, bulk_middle_);
    if (!surface) return false;
    rescue_before(*surface);
    const CellsBehind behind(*surface, cells_);
    Members taken;
    std::map<std::pair<int, int>, int> columns;
    for (std::size_t i = 0; i < body_.size(); ++i) {
      if (!body_[i]) continue;
      const auto place = cells_.place(i);
      if (behind(place) < 0) continue;
      taken.push_back(static_cast<std::uint32_t>(i));
      ++columns[{place[surface->across], place[2]}];
    }
    if (taken.empty()) return true;
    const double thick = static_cast<double>(taken.size()) / static_cast<double>(columns.size()) *
                         cells_.mm[surface->deep];
    if (thick > kMostCutMm) return true;
    for (const std::size_t cell : taken) {
      body_[cell] = 0;
      support_[cell] = 1;
    }
    surfaces_.push_back(*surface);
    return true;
  }

  Decision kinds() {
    CellMask full = filled(cells_, body_, Border::kClosed);
    for (std::size_t i = 0; i < full.size(); ++i) full[i] = full[i] && !support_[i];
    const CellMask inner = eroded(cells_, full, {1, 1, 1});
    const CellMask skin = dilated(cells_, full, {1, 1, 1});
    Decision decision{std::vector<CellKind>(cells_.count(), CellKind::kAir), surfaces_,
                      count(support_) > 0};
    for (std::size_t i = 0; i < full.size(); ++i) {
      if (support_[i])
        decision.kinds[i] = CellKind::kSupport;
      else if (inner[i])
        decision.kinds[i] = CellKind::kInside;
      else if (skin[i])
        decision.kinds[i] = CellKind::kSkin;
    }
    for (const Surface& surface : surfaces_) mark_cut(surface, decision.kinds);
    return decision;
  }

  void mark_cut(const Surface& surface, std::vector<CellKind>& kinds) const {
    const CellsBehind behind(surface, cells_);
    const double within = cells_.mm[surface.deep] * 1.5;
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      if (kinds[i] == CellKind::kAir) continue;
      if (kinds[i] == CellKind::kSupport && !body_near(i)) continue;
      if (std::abs(behind(cells_.place(i))) < within) {
        kinds[i] = CellKind::kCut;
      }
    }
  }

  bool body_near(std::size_t cell) const {
    const auto [x, y, z] = cells_.place(cell);
    for (int b = std::max(0, y - 1); b <= std::min(cells_.size[1] - 1, y + 1); ++b) {
      for (int a = std::max(0, x - 1); a <= std::min(cells_.size[0] - 1, x + 1); ++a) {
        if (body_[cells_.at(a, b, z)]) return true;
      }
    }
    return false;
  }

  const volume::Volume& volume_;
  const Cells& cells_;
  const ValueScale& scale_;
  CellMask matter_, core_, body_, support_;
  bool has_core_ = false;
  Members bulk_;  // the core, or all matter if there is none
  std::array<double, 3> bulk_middle_{};
  std::vector<Surface> surfaces_;
};

}  // namespace

Decision decide(const volume::Volume& volume, const Cells& cells, const ValueScale& scale) {
  return Decider(volume, cells, scale).decide();
}

}  // namespace diaphane::ingest
