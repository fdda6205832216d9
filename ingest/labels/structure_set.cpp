#include <algorithm>
#include <cmath>
#include <map>
#include <new>
#include <vector>

#include "common/try.h"
#include "ingest/dicom/data_set.h"
#include "ingest/labels/read_labels.h"

namespace diaphane::ingest {
namespace {

using dicom::DataSet;
using Vec = std::array<double, 3>;

constexpr std::uint32_t kFramesOfReference = 0x30060010;
constexpr std::uint32_t kStructures = 0x30060020, kNumber = 0x30060022, kOwnFrame = 0x30060024,
                        kName = 0x30060026;
constexpr std::uint32_t kStructureContours = 0x30060039, kColour = 0x3006002A,
                        kContours = 0x30060040, kShape = 0x30060042, kPoints = 0x30060050,
                        kReferencedNumber = 0x30060084;

/// A closed contour in one plane perpendicular to an axis of the scan, in voxel indices (centres of
/// voxels are whole numbers).
struct Contour {
  double height = 0;                           ///< position perpendicular to its plane
  std::vector<std::array<double, 2>> corners;  ///< positions along the other two axes, in order
};

/// What a structure set says about one structure.
struct Structure {
  std::uint32_t number = 0;
  std::string name, frame_of_reference;
};

/// Converts places in the patient's space to voxel indices of a scan.
class ToVoxels {
 public:
  explicit ToVoxels(const volume::Header& scan) : scan_(scan) {}

  Vec operator()(const double* place) const {
    Vec index{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t row = 0; row < 3; ++row) {
        index[axis] += scan_.direction[3 * row + axis] * (place[row] - (*scan_.origin)[row]);
      }
      index[axis] /= scan_.spacing[axis];
    }
    return index;
  }

 private:
  const volume::Header& scan_;
};

/// Returns the axis that is perpendicular to all contours of a structure, or nullopt.
std::optional<std::size_t> axis_across(const std::vector<std::vector<Vec>>& contours) {
  for (const std::size_t axis : {std::size_t{2}, std::size_t{1}, std::size_t{0}}) {
    const auto is_flat = [axis](const std::vector<Vec>& contour) {
      constexpr double kFlat = 0.1;  // voxels
      return std::all_of(contour.begin(), contour.end(), [&](const Vec& point) {
        return std::abs(point[axis] - contour.front()[axis]) < kFlat;
      });
    };
    if (std::all_of(contours.begin(), contours.end(), is_flat)) return axis;
  }
  return std::nullopt;
}

/// Fills contours into the voxels of a scan.
class Filler {
 public:
  Filler(const volume::Header& scan, std::size_t axis, std::uint8_t label,
         std::vector<std::uint8_t>& voxels)
      : size_(scan.size), axis_(axis), label_(label), voxels_(voxels) {
    std::size_t step = 1;
    for (std::size_t i = 0; i < 3; ++i) {
      steps_[i] = step;
      step *= size_[i];
    }
    across_ = axis == 0 ? std::array<std::size_t, 2>{1, 2}
                        : std::array<std::size_t, 2>{0, axis == 1 ? std::size_t{2} : 1};
  }

  /// Fills all contours of a structure. Returns whether a voxel lies in them.
  bool fill(const std::vector<std::vector<Vec>>& contours) {
    std::map<long, std::vector<Contour>> planes;  // by height in units of 1 / kSamePlane voxels
    for (const auto& points : contours) {
      Contour contour;
      double height = 0;
      for (const Vec& point : points) {
        height += point[axis_] / static_cast<double>(points.size());
        contour.corners.push_back({point[across_[0]], point[across_[1]]});
      }
      contour.height = height;
      constexpr double kSamePlane = 50;  // per voxel
      planes[std::lround(height * kSamePlane)].push_back(std::move(contour));
    }
    std::vector<const std::vector<Contour>*> stack;
    for (const auto& [height, plane] : planes) stack.push_back(&plane);
    bool any = false;
    for (std::uint32_t layer = 0; layer < size_[axis_]; ++layer) {
      if (const auto* plane = nearest(stack, layer)) any = fill_layer(*plane, layer) || any;
    }
    return any;
  }

 private:
  /// Returns the contours of the plane nearest to a layer of voxels, or null if it is further away
  /// than half the smallest distance of planes, and than half a voxel.
  const std::vector<Contour>* nearest(const std::vector<const std::vector<Contour>*>& stack,
                                      std::uint32_t layer) const {
    const auto height = [&](std::size_t i) { return stack[i]->front().height; };
    double least_gap = 0;
    for (std::size_t i = 1; i < stack.size(); ++i) {
      const double gap = height(i) - height(i - 1);
      if (least_gap == 0 || gap < least_gap) least_gap = gap;
    }
    std::size_t best = 0;
    for (std::size_t i = 1; i < stack.size(); ++i) {
      // At equal distance the lower plane counts, so that each layer has one.
      if (std::abs(height(i) - layer) < std::abs(height(best) - layer) - 1e-6) best = i;
    }
    // Contours on every second slice also apply to the slices between. Larger gaps in a structure
    // stay empty.
    constexpr double kRounding = 0.01;
    const double reach = std::max(0.5, 0.5 * least_gap) + kRounding;
    return std::abs(height(best) - layer) <= reach ? stack[best] : nullptr;
  }

  /// Marks the voxels whose centres an odd number of contours encloses.
  bool fill_layer(const std::vector<Contour>& plane, std::uint32_t layer) {
    bool any = false;
    std::vector<double> crossings;
    for (std::uint32_t line = 0; line < size_[across_[1]]; ++line) {
      crossings.clear();
      for (const Contour& contour : plane) add_crossings(contour, line, crossings);
      std::sort(crossings.begin(), crossings.end());
      for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
        const double last = size_[across_[0]] - 1.0;
        const double from = std::max(std::ceil(crossings[i]), 0.0);
        const double to = std::min(std::ceil(crossings[i + 1]) - 1, last);
        for (double at = from; at <= to; ++at) {
          voxels_[layer * steps_[axis_] + line * steps_[across_[1]] +
                  static_cast<std::size_t>(at) * steps_[across_[0]]] = label_;
          any = true;
        }
      }
    }
    return any;
  }

  /// Adds the places where a contour crosses a line. Each corner belongs to one of its two edges.
  static void add_crossings(const Contour& contour, std::uint32_t line,
                            std::vector<double>& crossings) {
    const double y = line;
    for (std::size_t i = 0; i < contour.corners.size(); ++i) {
      const auto& a = contour.corners[i];
      const auto& b = contour.corners[(i + 1) % contour.corners.size()];
      if ((a[1] <= y) == (b[1] <= y)) continue;
      crossings.push_back(a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]));
    }
  }

  std::array<std::uint32_t, 3> size_;
  std::array<std::size_t, 3> steps_{};
  std::size_t axis_;
  std::array<std::size_t, 2> across_{};
  std::uint8_t label_;
  std::vector<std::uint8_t>& voxels_;
};

class StructureSet {
 public:
  StructureSet(const DataSet& file, const volume::Header& scan, const LabelLimits& limits)
      : file_(file), scan_(scan), limits_(limits) {}

  Result<volume::LabelSet> read() {
    if (!scan_.origin) {
      return fail(ErrorCode::kInvalid,
                  "A structure set can only be added to a scan that says where it lies in the "
                  "patient.");
    }
    read_structures();
    set_.labels.size = scan_.size;
    set_.labels.voxels.resize(scan_.voxel_count());
    for (const DataSet& item : dicom::items_of(file_, kStructureContours)) {
      DIAPHANE_TRY(add(item));
    }
    if (set_.table.empty()) {
      return fail(ErrorCode::kInvalid, "The structure set contains no closed contours.");
    }
    if (!any_) {
      return fail(ErrorCode::kInvalid,
                  "These labels do not belong to this scan: none of them overlaps it.");
    }
    return std::move(set_);
  }

 private:
  void read_structures() {
    std::string common;
    const DataSet* frame = dicom::first_item(file_, kFramesOfReference);
    if (frame != nullptr) common = dicom::text_of(*frame, dicom::kFrameOfReferenceUid);
    for (const DataSet& item : dicom::items_of(file_, kStructures)) {
      Structure structure;
      structure.number = dicom::integer_of(item, kNumber).value_or(0);
      structure.name = volume::clean_label_name(dicom::text_of(item, kName));
      structure.frame_of_reference = dicom::text_of(item, kOwnFrame);
      if (structure.frame_of_reference.empty()) structure.frame_of_reference = common;
      structures_.emplace(structure.number, structure);
    }
  }

  /// Returns the closed contours of a structure in voxel indices.
  Result<std::vector<std::vector<Vec>>> contours_of(const DataSet& item) {
    const ToVoxels to_voxels(scan_);
    std::vector<std::vector<Vec>> contours;
    for (const DataSet& one : dicom::items_of(item, kContours)) {
      const std::string shape = dicom::text_of(one, kShape);
      if (shape != "CLOSED_PLANAR" && shape != "CLOSEDPLANAR_XOR") continue;
      const auto numbers = dicom::decimals_of(one, kPoints, 3 * limits_.points);
      if ((points_ += (numbers.size() + 2) / 3) > limits_.points) {
        return fail(ErrorCode::kTooLarge, "The structure set has more points than allowed.");
      }
      if (numbers.size() < 9 || numbers.size() % 3 != 0) {
        return fail(ErrorCode::kInvalid, "The structure set is damaged: a contour has no points.");
      }
      auto& contour = contours.emplace_back();
      for (std::size_t i = 0; i < numbers.size(); i += 3) {
        contour.push_back(to_voxels(&numbers[i]));
        constexpr double kFarthest = 1e7;
        for (const double v : contour.back()) {
          if (!(std::abs(v) < kFarthest)) {
            return fail(ErrorCode::kInvalid,
                        "The structure set is damaged: a point lies far outside the patient.");
          }
        }
      }
    }
    return contours;
  }

  Result<void> add(const DataSet& item) {
    const auto number = dicom::integer_of(item, kReferencedNumber);
    const auto found = structures_.find(number.value_or(0));
    if (!number || found == structures_.end()) {
      return fail(ErrorCode::kInvalid,
                  "The structure set is damaged: contours belong to no structure.");
    }
    const auto contours = contours_of(item);
    DIAPHANE_TRY(contours);
    if (contours->empty()) return {};  // a point, or a structure that nobody has drawn
    DIAPHANE_TRY(check_frame_of_reference(found->second.frame_of_reference, scan_));
    const auto axis = axis_across(*contours);
    if (!axis) {
      return fail(ErrorCode::kUnsupported,
                  "The contours of this structure set are not parallel to the slices of the scan, "
                  "which is not supported.");
    }
    if (set_.table.size() == volume::kMostLabels) {
      return fail(ErrorCode::kTooLarge, "The structure set has more than 255 structures.");
    }
    const auto colour = dicom::decimals_of(item, kColour, 3);
    volume::LabelEntry entry{std::max(*number, 1u), found->second.name,
                             volume::label_colour(set_.table.size())};
    for (std::size_t i = 0; colour.size() == 3 && i < 3; ++i) {
      entry.colour[i] = static_cast<std::uint8_t>(std::clamp(colour[i], 0.0, 255.0));
    }
    while (std::any_of(set_.table.begin(), set_.table.end(), [&](const volume::LabelEntry& other) {
      return other.number == entry.number;
    })) {
      ++entry.number;  // numbers may start at 0 or occur twice
    }
    set_.table.push_back(std::move(entry));
    const auto label = static_cast<std::uint8_t>(set_.table.size());
    any_ = Filler(scan_, *axis, label, set_.labels.voxels).fill(*contours) || any_;
    return {};
  }

  const DataSet& file_;
  const volume::Header& scan_;
  const LabelLimits& limits_;
  std::map<std::uint32_t, Structure> structures_;
  std::uint64_t points_ = 0;
  volume::LabelSet set_;
  bool any_ = false;
};

}  // namespace

Result<volume::LabelSet> read_structure_set(const DataSet& file, const volume::Header& scan,
                                            const LabelLimits& limits) {
  return StructureSet(file, scan, limits).read();
}

}  // namespace diaphane::ingest
