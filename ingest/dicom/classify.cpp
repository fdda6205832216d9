#include "ingest/dicom/classify.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <utility>

#include "ingest/dicom/stack.h"
#include "ingest/dicom/values.h"

namespace diaphane::dicom {
namespace {

using Indices = std::vector<std::size_t>;

std::string counted(std::size_t n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

/// One rule after another over the slices that are left; the first that objects decides.
class Judge {
 public:
  Judge(const std::vector<Slice>& slices, std::uint64_t most_voxels)
      : slices_(slices), most_voxels_(most_voxels), kept_(slices.size()) {
    std::iota(kept_.begin(), kept_.end(), std::size_t{0});
  }

  Assessment judge() {
    const bool suitable = images_only() && originals_only() && once_each() && without_scouts() &&
                          single_frames() && grey() && placed() && one_orientation() &&
                          enough_slices() && one_picture_size() && one_scale() &&
                          readable_pixels() && regular_stack();
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
      return refuse("no_slices", "This series holds no slices of a CT, MR or PET scan.");
    }
    result_.modality = first().modality;
    if (any([&](const Slice& s) { return s.modality != first().modality; })) {
      return refuse("mixed", "The series mixes pictures of several kinds of scan.");
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
      return refuse("views_not_slices", "These are views of a scan, not slices.");
    }
    if (any([](const Slice& s) {
          return !s.image_type.empty() && s.image_type[0] != "ORIGINAL";
        })) {
      return refuse("not_original",
                    "These pictures were computed from a scan; only original slices are accepted.");
    }
    return true;
  }

  bool once_each() {
    std::map<std::string, const Slice*> seen;
    bool contradiction = false;
    const std::size_t copies = drop([&](const Slice& s) {
      if (s.sop_uid.empty()) return false;
      const auto [found, is_new] = seen.emplace(s.sop_uid, &s);
      if (is_new) return false;
      contradiction = contradiction || found->second->position != s.position;
      return true;
    });
    if (contradiction) {
      return refuse("repeated_identifier", "Different slices carry the same identifier.");
    }
    if (copies > 0) {
      result_.repairs.push_back(counted(copies, "slice was", "slices were") +
                                " there twice; one of each was kept");
    }
    return true;
  }

  bool without_scouts() {
    scouts_ += drop([](const Slice& s) { return s.is_scout(); });
    if (kept_.empty()) {
      return refuse("scout", "This is a scout (a picture to plan the scan by), not a volume.");
    }
    return true;
  }

  bool single_frames() {
    if (any([](const Slice& s) { return s.kind == Kind::kMultiFrame || s.frames != 1; })) {
      return refuse(
          "multi_frame",
          "Several slices are packed in one file (multi-frame); this is not supported yet.");
    }
    return true;
  }

  bool grey() {
    if (any([](const Slice& s) {
          return s.samples != 1 ||
                 (s.photometric != "MONOCHROME1" && s.photometric != "MONOCHROME2");
        })) {
      return refuse("screenshots", "These are screenshots in colour, not slices of a scan.");
    }
    return true;
  }

  bool placed() {
    if (any([](const Slice& s) { return !s.position || !s.orientation; })) {
      return refuse("no_position", "Some slices do not say where they lie in the patient.");
    }
    if (any([](const Slice& s) {
          return !s.pixel_spacing || !((*s.pixel_spacing)[0] > 0) || !((*s.pixel_spacing)[1] > 0) ||
                 s.rows == 0 || s.columns == 0;
        })) {
      return refuse("no_spacing", "Some slices do not say how large their pixels are.");
    }
    if (any([](const Slice& s) {
          Axes axes;
          return !make_axes(*s.orientation, axes);
        })) {
      return refuse("bad_orientation", "The orientation of some slices makes no sense.");
    }
    return true;
  }

  /// Keeps the orientation that most slices share. A few others are scouts (thesis 5.2); many are
  /// not.
  bool one_orientation() {
    std::vector<std::pair<Axes, Indices>> groups;
    for (const std::size_t i : kept_) {
      Axes axes;
      make_axes(*slices_[i].orientation, axes);
      const auto same = [&](const std::pair<Axes, Indices>& group) {
        constexpr double kCosine = 0.99999;  // a quarter of a degree
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
      return refuse("views_not_slices", "These are views from many sides, not slices.");
    }
    constexpr std::size_t kMostScouts = 3;
    if (others > kMostScouts && largest->second.size() >= kFewestSlices) {
      return refuse("mixed", "The series mixes slices of several orientations.");
    }
    scouts_ += others;
    axes_ = largest->first;
    kept_ = largest->second;
    if (scouts_ > 0) {
      result_.repairs.push_back(counted(scouts_, "scout picture was", "scout pictures were") +
                                " left out");
    }
    return true;
  }

  bool enough_slices() {
    if (kept_.size() >= kFewestSlices) return true;
    return refuse("too_few_slices", "Too few slices: " + std::to_string(kept_.size()) + ", and " +
                                        std::to_string(kFewestSlices) +
                                        " are needed for a volume.");
  }

  bool one_picture_size() {
    const auto differs = [&](const Slice& s) {
      const auto& a = *s.pixel_spacing;
      const auto& b = *first().pixel_spacing;
      return s.rows != first().rows || s.columns != first().columns ||
             std::abs(a[0] - b[0]) > 1e-3 * b[0] || std::abs(a[1] - b[1]) > 1e-3 * b[1];
    };
    if (any(differs)) {
      return refuse("mixed", "The series mixes slices of different sizes.");
    }
    result_.size = {first().columns, first().rows, static_cast<std::uint32_t>(kept_.size())};
    if (std::uint64_t{result_.size[0]} * result_.size[1] * result_.size[2] > most_voxels_) {
      return refuse("over_quota", "The volume would be larger than is allowed here.");
    }
    return true;
  }

  bool one_scale() {
    if (any([](const Slice& s) { return s.has_lookup_table; })) {
      return refuse("lookup_table", "The slices are scaled by a table; this is not supported yet.");
    }
    if (any([&](const Slice& s) { return s.photometric != first().photometric; })) {
      return refuse("mixed", "The series mixes slices and negatives of slices.");
    }
    if (any([&](const Slice& s) { return !(s.rescale == first().rescale); })) {
      return refuse("varying_rescale",
                    "Each slice has a scale of its own; this is not supported yet.");
    }
    const Rescale& scale = first().rescale;
    if (scale.slope == 0) return refuse("bad_rescale", "The scale of the slices makes no sense.");
    if (result_.modality == volume::Modality::kCt && !scale.present &&
        any([](const Slice& s) { return !s.layout.is_signed; })) {
      return refuse("no_rescale",
                    "The slices do not say how their numbers become Hounsfield units.");
    }
    return true;
  }

  bool readable_pixels() {
    if (any([](const Slice& s) { return !is_readable(s.layout); })) {
      return refuse("pixel_format", "The pixels are stored in a form that is not supported.");
    }
    // In CT padding becomes air; elsewhere it is air already when it is nothing.
    if (result_.modality != volume::Modality::kCt && any([](const Slice& s) {
          return s.padding && ((*s.padding)[0] != 0 || (*s.padding)[1] != 0);
        })) {
      return refuse("padding",
                    "The slices mark missing pixels in a way that is not supported yet.");
    }
    return true;
  }

  bool regular_stack() {
    std::vector<Vec3> positions;
    for (const std::size_t i : kept_) positions.push_back(*slices_[i].position);
    const auto& pixel = *first().pixel_spacing;
    Stack stack = arrange(positions, axes_, std::min(pixel[0], pixel[1]));
    if (!stack.regular) return refuse(stack.code.c_str(), std::move(stack.text));
    const double height = stack.spacing * static_cast<double>(kept_.size());
    if (height < kShortestStack) {
      char text[96];
      std::snprintf(text, sizeof text,
                    "Too few slices: together they are %.1f mm high, and %.0f mm are needed.",
                    height, kShortestStack);
      return refuse("too_few_slices", text);
    }
    for (const std::size_t i : stack.order) result_.order.push_back(kept_[i]);
    describe(stack, pixel);
    return true;
  }

  void describe(const Stack& stack, const std::array<double, 2>& pixel) {
    result_.spacing = {pixel[1], pixel[0], stack.spacing};
    const Vec3* columns[] = {&axes_.row, &axes_.column, &axes_.normal};
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        result_.direction[3 * row + axis] = (*columns[axis])[row];
      }
    }
    const Slice& middle = slices_[result_.order[result_.order.size() / 2]];
    result_.window_center = middle.window_center;
    result_.window_width = middle.window_width;
    if (stack.jitter > kJitterMm) {
      char text[96];
      std::snprintf(text, sizeof text,
                    "slices lie up to %.2f mm off their places; the mean distance was used",
                    stack.jitter);
      result_.repairs.emplace_back(text);
    }
    if (first().photometric == "MONOCHROME1")
      result_.repairs.emplace_back("the negative was inverted");
  }

  const std::vector<Slice>& slices_;
  std::uint64_t most_voxels_;
  Indices kept_;
  std::size_t scouts_ = 0;
  Axes axes_;
  Assessment result_;
};

}  // namespace

Assessment classify(const std::vector<Slice>& slices, std::uint64_t most_voxels) {
  return Judge(slices, most_voxels).judge();
}

std::string plane_name(const std::array<double, 9>& direction) {
  constexpr double kNearly = 0.966;  // within 15 degrees
  const char* const names[] = {"sagittal", "coronal", "axial"};
  for (std::size_t row = 0; row < 3; ++row) {
    if (std::abs(direction[3 * row + 2]) > kNearly) return names[row];
  }
  return "oblique";
}

}  // namespace diaphane::dicom
