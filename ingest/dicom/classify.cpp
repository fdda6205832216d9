#include "ingest/dicom/classify.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <utility>

#include "ingest/dicom/phases.h"
#include "ingest/dicom/stack.h"
#include "ingest/dicom/values.h"

namespace diaphane::dicom {
namespace {

using Indices = std::vector<std::size_t>;

/// Scales of real scans are far below these limits. Above them, no value of a slice fits into 16
/// bits, or the numbers of the header overflow.
constexpr double kLargestCtSlope = 1000;
constexpr double kLargestCtIntercept = 1e5;
constexpr double kSmallestSlope = 1e-12, kLargestSlope = 1e12;
constexpr double kLargestStored = 65535;

bool is_plausible(const Rescale& scale, bool is_ct) {
  const double slope = std::abs(scale.slope);
  if (!std::isfinite(slope) || !std::isfinite(scale.intercept)) return false;
  if (slope < kSmallestSlope) return false;
  if (!is_ct) return slope <= kLargestSlope;
  return slope <= kLargestCtSlope && std::abs(scale.intercept) <= kLargestCtIntercept;
}

/// Applies one rule after another to the remaining slices. The first rule that objects decides.
class Judge {
 public:
  Judge(const std::vector<Slice>& slices, std::uint64_t most_voxels)
      : slices_(slices), most_voxels_(most_voxels), kept_(slices.size()) {
    std::iota(kept_.begin(), kept_.end(), std::size_t{0});
  }

  Assessment judge() {
    const bool suitable = images_only() && originals_only() && once_each() && without_scouts() &&
                          single_frames() && grey() && placed() && one_orientation() &&
                          one_picture_size() && enough_slices() && one_scale() &&
                          readable_pixels() && stacked();
    result_.suitable = suitable;
    if (!suitable) result_.order.clear();
    return std::move(result_);
  }

 private:
  bool refuse(const char* code, std::string text) {
    result_.code = code;
    result_.text = std::move(text);
    return false;
  }
  const Slice& at(std::size_t i) const { return slices_[kept_[i]]; }
  const Slice& first() const { return slices_[kept_.front()]; }
  template <typename Predicate>
  bool any(Predicate predicate) const {
    return std::any_of(kept_.begin(), kept_.end(),
                       [&](std::size_t i) { return predicate(slices_[i]); });
  }
  template <typename Predicate>
  std::size_t drop(Predicate predicate) {
    return std::erase_if(kept_, [&](std::size_t i) { return predicate(slices_[i]); });
  }

  bool images_only() {
    drop([](const Slice& s) { return s.kind == Kind::kOther || !s.has_pixels; });
    if (kept_.empty()) {
      return refuse("no_slices", "This series contains no CT, MR or PET slices.");
    }
    result_.modality = first().modality;
    if (any([&](const Slice& s) { return s.modality != first().modality; })) {
      return refuse("mixed", "This series mixes images from several types of scan.");
    }
    return true;
  }

  bool originals_only() {
    const auto has_type = [](const Slice& s, std::initializer_list<const char*> names) {
      return std::any_of(s.image_type.begin(), s.image_type.end(), [&](const std::string& type) {
        return std::any_of(names.begin(), names.end(),
                           [&](const char* name) { return type.find(name) != std::string::npos; });
      });
    };
    if (any([&](const Slice& s) {
          return has_type(s, {"PROJECTION", "MIP", "MINIP", "ROTAT", "VRT"});
        })) {
      return refuse("views_not_slices", "These are rendered views of a scan, not slices.");
    }
    if (any([](const Slice& s) {
          // "MIXED" means that each frame states its own type.
          const auto& type = s.image_type;
          const bool compressed = s.is_lossy && type.size() > 1 && type[1] == "PRIMARY";
          return !type.empty() && type[0] != "ORIGINAL" && type[0] != "MIXED" &&
                 !(type[0] == "DERIVED" && compressed);
        })) {
      return refuse("not_original",
                    "These images were computed from a scan. Only original slices are accepted.");
    }
    return true;
  }

  bool once_each() {
    std::map<std::pair<std::string, std::size_t>, const Slice*> seen;  // by identifier and frame
    bool contradiction = false;
    const std::size_t copies = drop([&](const Slice& s) {
      if (s.sop_uid.empty()) return false;
      const auto [found, is_new] = seen.emplace(std::pair(s.sop_uid, s.frame), &s);
      if (is_new) return false;
      contradiction = contradiction || found->second->position != s.position;
      return true;
    });
    if (contradiction) {
      return refuse("repeated_identifier", "Several different slices have the same identifier.");
    }
    if (copies > 0) {
      result_.repairs.push_back(counted(copies, "slice was", "slices were") +
                                " duplicated; one copy of each was kept");
    }
    return true;
  }

  bool without_scouts() {
    scouts_ += drop([](const Slice& s) { return s.is_scout(); });
    if (kept_.empty()) {
      return refuse(
          "scout",
          "This is an overview image that was used to plan the scan, not the scan itself.");
    }
    return true;
  }

  bool single_frames() {
    if (any([](const Slice& s) { return s.frames != 1; })) {
      return refuse("no_position",
                    "Several images are stored in one file, and the file does not specify their "
                    "positions in the body.");
    }
    return true;
  }

  bool grey() {
    if (any([](const Slice& s) {
          return s.samples != 1 ||
                 (s.photometric != "MONOCHROME1" && s.photometric != "MONOCHROME2");
        })) {
      return refuse("screenshots", "These are colour screenshots, not slices of a scan.");
    }
    return true;
  }

  bool placed() {
    if (any([](const Slice& s) { return !s.position || !s.orientation; })) {
      return refuse("no_position", "The position in the body is missing from some slices.");
    }
    if (any([](const Slice& s) {
          return !s.pixel_spacing || !((*s.pixel_spacing)[0] > 0) || !((*s.pixel_spacing)[1] > 0) ||
                 s.rows == 0 || s.columns == 0;
        })) {
      return refuse("no_spacing", "The pixel size is missing from some slices.");
    }
    if (any([](const Slice& s) {
          Axes axes;
          return !make_axes(*s.orientation, axes);
        })) {
      return refuse("bad_orientation", "Some slices have an invalid orientation.");
    }
    return true;
  }

  /// Keeps the orientation that most slices share. Skips a few slices of other orientations as
  /// scouts (thesis 5.2), and refuses a series with many.
  bool one_orientation() {
    std::vector<std::pair<Axes, Indices>> groups;
    for (const std::size_t i : kept_) {
      Axes axes;
      make_axes(*slices_[i].orientation, axes);
      const auto same = [&](const std::pair<Axes, Indices>& group) {
        constexpr double kCosine = 0.99999;  // cosine of a quarter of a degree
        return dot(group.first.row, axes.row) > kCosine &&
               dot(group.first.column, axes.column) > kCosine;
      };
      auto found = std::find_if(groups.begin(), groups.end(), same);
      if (found == groups.end()) found = groups.insert(groups.end(), {axes, {}});
      found->second.push_back(i);
    }
    const auto largest = std::max_element(
        groups.begin(), groups.end(),
        [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    const std::size_t others = kept_.size() - largest->second.size();
    if (groups.size() > 3 && 2 * others > kept_.size()) {
      return refuse("views_not_slices",
                    "These are views from many directions, not parallel slices.");
    }
    constexpr std::size_t kMostScouts = 3;
    if (others > kMostScouts && largest->second.size() >= kFewestSlices) {
      return refuse("mixed", "This series mixes slices in several orientations.");
    }
    scouts_ += others;
    axes_ = largest->first;
    kept_ = largest->second;
    if (scouts_ > 0) {
      result_.repairs.push_back(counted(scouts_, "overview image was", "overview images were") +
                                " skipped");
    }
    return true;
  }

  bool enough_slices() {
    if (kept_.size() < kFewestSlices && others_ > 0 && kept_.size() + others_ >= kFewestSlices) {
      return refuse(
          "mixed",
          "This series mixes slices of different sizes, with too few of each size for a 3D image.");
    }
    if (kept_.size() >= kFewestSlices) return true;
    return refuse("too_few_slices", "Too few slices: this series has " +
                                        std::to_string(kept_.size()) + ", and at least " +
                                        std::to_string(kFewestSlices) +
                                        " are needed for a 3D image.");
  }

  /// Case 14: keeps the image size that most slices share.
  bool one_picture_size() {
    const auto same = [](const Slice& s, const Slice& t) {
      const auto& a = *s.pixel_spacing;
      const auto& b = *t.pixel_spacing;
      return s.rows == t.rows && s.columns == t.columns && std::abs(a[0] - b[0]) <= 1e-3 * b[0] &&
             std::abs(a[1] - b[1]) <= 1e-3 * b[1];
    };
    std::vector<Indices> groups;
    for (const std::size_t i : kept_) {
      auto found = std::find_if(groups.begin(), groups.end(), [&](const Indices& group) {
        return same(slices_[i], slices_[group.front()]);
      });
      if (found == groups.end()) found = groups.insert(groups.end(), Indices{});
      found->push_back(i);
    }
    const auto largest =
        std::max_element(groups.begin(), groups.end(),
                         [](const Indices& a, const Indices& b) { return a.size() < b.size(); });
    others_ = kept_.size() - largest->size();
    kept_ = Indices(*largest);
    if (others_ > 0) {
      result_.repairs.push_back(counted(others_, "slice", "slices") + " of a different size " +
                                (others_ == 1 ? "was" : "were") + " skipped");
    }
    return true;
  }

  bool one_scale() {
    if (any([](const Slice& s) { return s.has_lookup_table; })) {
      return refuse("lookup_table",
                    "The slices use a lookup table for their values, which is not supported yet.");
    }
    if (any([&](const Slice& s) { return s.photometric != first().photometric; })) {
      return refuse("mixed", "This series mixes normal and inverted slices.");
    }
    const Rescale& scale = first().rescale;
    const bool is_ct = result_.modality == volume::Modality::kCt;
    if (any([&](const Slice& s) { return !is_plausible(s.rescale, is_ct); })) {
      return refuse("bad_rescale", "The slices have an invalid value scale.");
    }
    const bool varies = any([&](const Slice& s) {
      return s.rescale.slope != scale.slope || s.rescale.intercept != scale.intercept;
    });
    if (varies && result_.modality != volume::Modality::kCt) {
      // Case 15: the slice with the largest scale keeps its values, and the values of the others
      // become smaller.
      for (const std::size_t i : kept_) {
        result_.unit = std::max(result_.unit, std::abs(slices_[i].rescale.slope));
      }
      if (any([&](const Slice& s) {
            return std::abs(s.rescale.intercept) > kLargestStored * result_.unit;
          })) {
        return refuse("bad_rescale", "The slices have an invalid value scale.");
      }
      result_.repairs.emplace_back(
          "the slices had different value scales and were converted to a single one");
    }
    if (result_.modality == volume::Modality::kCt && !scale.present &&
        any([](const Slice& s) { return !s.layout.is_signed; })) {
      return refuse("no_rescale",
                    "The slices do not specify how to convert their values to Hounsfield units.");
    }
    return true;
  }

  bool readable_pixels() {
    if (any([](const Slice& s) { return !is_readable(s.layout); })) {
      return refuse("pixel_format", "The pixel format is not supported.");
    }
    return true;
  }

  /// Splits a series that repeats its positions into phases, and keeps the first of them.
  bool one_phase() {
    const std::vector<Indices> places = places_of(slices_, kept_, axes_);
    const std::size_t n = kept_.size(), fewest = kFewestRepeats * places.size();
    if (places.size() == 1 || n == places.size() || n < fewest - places.size() / 10) return true;
    const auto& pixel = *first().pixel_spacing;
    PhasePlan plan = split_phases(slices_, places, std::min(pixel[0], pixel[1]));
    if (!plan.code.empty()) return refuse(plan.code.c_str(), std::move(plan.text));
    kept_ = plan.slices.front();
    if (!enough_slices()) return false;
    if (plan.incomplete > 0) {
      result_.repairs.push_back(counted(plan.incomplete, "phase was", "phases were") +
                                " incomplete and left out");
    }
    if (plan.uncommon > 0) {
      result_.repairs.push_back(counted(plan.uncommon, "slice", "slices") +
                                " at the ends of some phases " +
                                (plan.uncommon == 1 ? "was" : "were") +
                                " left out, because other phases do not have them");
    }
    phases_ = std::move(plan.phases);
    phase_slices_ = std::move(plan.slices);
    return true;
  }

  /// Keeps every n-th phase so that all of them fit.
  void thin_phases() {
    const auto& size = result_.size;
    const std::uint64_t one = std::uint64_t{size[0]} * size[1] * size[2];
    const std::uint64_t most = std::min<std::uint64_t>(volume::kMostPhases, most_voxels_ / one);
    const std::size_t all = phases_.size();
    if (all <= most) return;
    const std::size_t step = (all + most - 1) / most;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < all; i += step, ++kept) {
      phases_[kept] = phases_[i];
      phase_slices_[kept] = phase_slices_[i];
    }
    phases_.resize(kept);
    phase_slices_.resize(kept);
    result_.repairs.push_back(
        "only " + std::to_string(kept) + " of " + std::to_string(all) +
        " phases were kept, because all of them would be larger than allowed");
  }

  bool stacked() {
    if (!one_phase()) return false;
    std::vector<Vec3> positions;
    for (const std::size_t i : kept_) positions.push_back(*slices_[i].position);
    const auto& pixel = *first().pixel_spacing;
    Stack stack = arrange(positions, axes_, std::min(pixel[0], pixel[1]));
    if (!stack.is_volume) {
      const bool film = stack.code == "one_position" && first().one_of_frames;
      if (film)
        return refuse("cine", "This is a video of a single place in the body, not a 3D scan.");
      return refuse(stack.code.c_str(), std::move(stack.text));
    }
    const std::size_t slices = stack.sources.empty() ? kept_.size() : stack.sources.size();
    const double height = stack.spacing * static_cast<double>(slices);
    if (height < kShortestStack) {
      char text[96];
      std::snprintf(text, sizeof text,
                    "Too few slices: together they cover %.1f mm, and at least %.0f mm are needed.",
                    height, kShortestStack);
      return refuse("too_few_slices", text);
    }
    for (const std::size_t i : stack.order) result_.order.push_back(kept_[i]);
    shape(stack, pixel, slices);
    if (!fits()) return refuse("over_quota", "The 3D image would be larger than allowed.");
    if (!phases_.empty()) {
      thin_phases();
      result_.order.clear();
      for (const Indices& phase : phase_slices_) {
        for (const std::size_t i : stack.order) result_.order.push_back(phase[i]);
      }
      if (phases_.size() > 1) result_.phases = std::move(phases_);
    }
    describe(stack);
    result_.sources = std::move(stack.sources);
    return true;
  }

  bool fits() const {
    const auto& size = result_.size;
    return *std::max_element(size.begin(), size.end()) <= 65535 &&
           std::uint64_t{size[0]} * size[1] <= most_voxels_ / size[2];
  }

  /// Computes the box of the volume. If slices are straightened, the box contains all of them.
  void shape(const Stack& stack, const std::array<double, 2>& pixel, std::size_t slices) {
    result_.spacing = {pixel[1], pixel[0], stack.spacing};
    const Vec3* columns[] = {&axes_.row, &axes_.column, &axes_.normal};
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        result_.direction[3 * row + axis] = (*columns[axis])[row];
      }
    }
    std::array<double, 2> low{}, high{};  // extent of the first pixels of all slices, in pixels
    for (const Source& source : stack.sources) {
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const double at = source.shift[axis] / result_.spacing[axis];
        low[axis] = std::min(low[axis], at);
        high[axis] = std::max(high[axis], at);
      }
    }
    const auto grown = [&](std::uint16_t n, std::size_t axis) {
      constexpr double kNegligible = 1e-3;
      result_.corner[axis] = std::floor(low[axis] + kNegligible);
      return n +
             static_cast<std::uint32_t>(std::ceil(high[axis] - result_.corner[axis] - kNegligible));
    };
    result_.size = {grown(first().columns, 0), grown(first().rows, 1),
                    static_cast<std::uint32_t>(slices)};
    const Vec3& at = *slices_[result_.order.front()].position;
    for (std::size_t i = 0; i < 3; ++i) {
      result_.origin[i] = at[i] + result_.corner[0] * result_.spacing[0] * axes_.row[i] +
                          result_.corner[1] * result_.spacing[1] * axes_.column[i];
    }
  }

  void describe(const Stack& stack) {
    const Slice& middle = slices_[result_.order[result_.order.size() / 2]];
    result_.window_center = middle.window_center;
    result_.window_width = middle.window_width;
    if (result_.modality != volume::Modality::kCt) {
      // The window is in scaled units, but the volume keeps stored units, or those of `unit`.
      const Rescale& scale = middle.rescale;
      const double unit = result_.unit > 0 ? result_.unit : std::abs(scale.slope);
      const double offset = result_.unit > 0 ? 0 : scale.intercept;
      const double sign = result_.unit > 0 || scale.slope > 0 ? 1 : -1;
      result_.window_center = sign * (result_.window_center - offset) / unit;
      result_.window_width /= unit;
    }
    char text[160];
    if (stack.tilt > 0) {
      std::snprintf(text, sizeof text, "gantry tilt of %.1f degrees corrected", stack.tilt);
      result_.repairs.emplace_back(text);
    }
    if (stack.missing > 0) {
      result_.repairs.push_back(counted(stack.missing, "slice was", "slices were") +
                                " missing and interpolated from the neighbouring slices");
    }
    if (stack.varying[1] > 0) {
      std::snprintf(text, sizeof text,
                    "slice spacing varied from %.2f to %.2f mm and was resampled to %.2f mm, so "
                    "small details may be blurred",
                    stack.varying[0], stack.varying[1], stack.spacing);
      result_.repairs.emplace_back(text);
    }
    if (stack.jitter > kJitterMm) {
      std::snprintf(text, sizeof text,
                    "slice positions deviated by up to %.2f mm; the mean spacing was used",
                    stack.jitter);
      result_.repairs.emplace_back(text);
    }
    const bool has_units = result_.modality == volume::Modality::kCt || result_.unit > 0;
    if (shows_negative(first()) && !has_units)
      result_.repairs.emplace_back("the inverted (negative) image was converted back");
  }

  const std::vector<Slice>& slices_;
  std::uint64_t most_voxels_;
  Indices kept_;
  std::size_t scouts_ = 0;
  std::size_t others_ = 0;             ///< number of slices of another size
  std::vector<volume::Phase> phases_;  ///< empty: no position is repeated
  std::vector<Indices> phase_slices_;  ///< of each phase, at the positions of `kept_`
  Axes axes_;
  Assessment result_;
};

}  // namespace

Assessment classify(const std::vector<Slice>& slices, std::uint64_t most_voxels) {
  return Judge(slices, most_voxels).judge();
}

std::string plane_name(const std::array<double, 9>& direction) {
  constexpr double kNearly = 0.966;  // cosine of 15 degrees
  const char* const names[] = {"sagittal", "coronal", "axial"};
  for (std::size_t row = 0; row < 3; ++row) {
    if (std::abs(direction[3 * row + 2]) > kNearly) return names[row];
  }
  return "oblique";
}

}  // namespace diaphane::dicom
