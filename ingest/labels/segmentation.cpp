#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "common/try.h"
#include "ingest/dicom/data_set.h"
#include "ingest/dicom/stack.h"
#include "ingest/labels/read_labels.h"

namespace diaphane::ingest {
namespace {

using dicom::DataSet;
using dicom::Vec3;

constexpr std::uint32_t kRows = 0x00280010, kColumns = 0x00280011, kBitsAllocated = 0x00280100;
constexpr std::uint32_t kSegmentationType = 0x00620001, kSegments = 0x00620002;
constexpr std::uint32_t kSegmentNumber = 0x00620004, kSegmentLabel = 0x00620005,
                        kSegmentColour = 0x0062000D, kLargestFraction = 0x0062000E;
constexpr std::uint32_t kSegmentOfFrame = 0x0062000A, kReferencedSegment = 0x0062000B;
constexpr std::uint32_t kShared = 0x52009229, kPerFrame = 0x52009230;
constexpr std::uint32_t kPlanePosition = 0x00209113, kPosition = 0x00200032;
constexpr std::uint32_t kPlaneOrientation = 0x00209116, kOrientation = 0x00200037;
constexpr std::uint32_t kMeasures = 0x00289110, kPixelSpacing = 0x00280030, kThickness = 0x00180050,
                        kSliceSpacing = 0x00180088;

tl::unexpected<Error> damaged(const std::string& what) {
  return fail(ErrorCode::kInvalid, "The segmentation is damaged: " + what + ".");
}

/// Converts the CIELab colour of DICOM (PS3.3, C.10.7.1.1; white D50) to sRGB.
std::array<std::uint8_t, 3> colour_of(const std::vector<std::uint16_t>& lab) {
  const double l = lab[0] * 100.0 / 65535, a = lab[1] * 255.0 / 65535 - 128,
               b = lab[2] * 255.0 / 65535 - 128;
  const double fy = (l + 16) / 116, fx = fy + a / 500, fz = fy - b / 200;
  const auto cube = [](double f) {
    constexpr double kLinear = 6.0 / 29;
    return f > kLinear ? f * f * f : 3 * kLinear * kLinear * (f - 4.0 / 29);
  };
  const double x = 0.9642 * cube(fx), y = cube(fy), z = 0.8249 * cube(fz);
  // Converts from D50 to linear sRGB, with Bradford's adaptation to D65.
  const std::array<double, 3> linear{3.1339 * x - 1.6169 * y - 0.4906 * z,
                                     -0.9788 * x + 1.9161 * y + 0.0335 * z,
                                     0.0719 * x - 0.2290 * y + 1.4052 * z};
  std::array<std::uint8_t, 3> colour{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double c = std::clamp(linear[i], 0.0, 1.0);
    const double shown = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
    colour[i] = static_cast<std::uint8_t>(std::lround(255 * shown));
  }
  return colour;
}

/// One frame: a mask of one segment in one plane.
struct Frame {
  std::uint8_t label = 0;  ///< place in the table, 1 or more
  Vec3 position{};
};

/// Reads the frames and arranges them as planes of one grid.
class Segmentation {
 public:
  Segmentation(const DataSet& file, const LabelLimits& limits) : file_(file), limits_(limits) {}

  Result<LabelImage> read() {
    DIAPHANE_TRY(read_form());
    DIAPHANE_TRY(read_segments());
    DIAPHANE_TRY(read_frames());
    DIAPHANE_TRY(arrange());
    DIAPHANE_TRY(read_pixels());
    image_.frame_of_reference = dicom::text_of(file_, dicom::kFrameOfReferenceUid);
    return std::move(image_);
  }

 private:
  Result<void> read_form() {
    const std::string type = dicom::text_of(file_, kSegmentationType);
    fractional_ = type == "FRACTIONAL";
    if (!fractional_ && type != "BINARY") {
      return fail(ErrorCode::kUnsupported,
                  "Only binary and fractional DICOM segmentations are supported.");
    }
    const auto rows = dicom::short_of(file_, kRows), columns = dicom::short_of(file_, kColumns);
    const auto bits = dicom::short_of(file_, kBitsAllocated);
    if (!rows || !columns || *rows == 0 || *columns == 0) return damaged("it has no size");
    if (bits != (fractional_ ? 8 : 1)) return damaged("its pixels have an unexpected form");
    image_.size = {*columns, *rows, 0};
    largest_ = dicom::short_of(file_, kLargestFraction).value_or(255);
    if (fractional_ && largest_ == 0) return damaged("its fractions have no scale");
    return {};
  }

  Result<void> read_segments() {
    for (const DataSet& item : dicom::items_of(file_, kSegments)) {
      const auto number = dicom::short_of(item, kSegmentNumber);
      if (!number || *number == 0) return damaged("a segment has no number");
      if (image_.table.size() == volume::kMostLabels) {
        return fail(ErrorCode::kTooLarge, "The segmentation has more than 255 segments.");
      }
      const auto place = static_cast<std::uint8_t>(image_.table.size() + 1);
      if (!places_.emplace(*number, place).second) {
        return damaged("two segments have the same number");
      }
      const auto lab = dicom::shorts_of(item, kSegmentColour);
      image_.table.push_back(
          {*number, volume::clean_label_name(dicom::text_of(item, kSegmentLabel)),
           lab.size() == 3 ? colour_of(lab) : volume::label_colour(image_.table.size())});
    }
    if (image_.table.empty()) return fail(ErrorCode::kInvalid, "The file contains no labels.");
    return {};
  }

  /// Returns a functional group of a frame, or the one that all frames share.
  const DataSet* group(const DataSet& frame, std::uint32_t tag) const {
    if (const DataSet* own = dicom::first_item(frame, tag)) return own;
    const DataSet* shared = dicom::first_item(file_, kShared);
    return shared == nullptr ? nullptr : dicom::first_item(*shared, tag);
  }
  std::vector<double> numbers(const DataSet& frame, std::uint32_t tag, std::uint32_t value) const {
    const DataSet* found = group(frame, tag);
    return found == nullptr ? std::vector<double>() : dicom::decimals_of(*found, value, 6);
  }

  Result<void> read_frames() {
    for (const DataSet& item : dicom::items_of(file_, kPerFrame)) {
      const DataSet* segment = group(item, kSegmentOfFrame);
      const auto number = segment == nullptr ? std::optional<std::uint16_t>()
                                             : dicom::short_of(*segment, kReferencedSegment);
      const auto place = places_.find(number.value_or(0));
      if (place == places_.end()) return damaged("a frame belongs to no segment");
      const auto position = numbers(item, kPlanePosition, kPosition);
      const auto orientation = numbers(item, kPlaneOrientation, kOrientation);
      const auto spacing = numbers(item, kMeasures, kPixelSpacing);
      if (position.size() != 3 || orientation.size() != 6 || spacing.size() != 2) {
        return damaged("the position of a frame is missing");
      }
      DIAPHANE_TRY(check_same(orientation, spacing));
      frames_.push_back({place->second, {position[0], position[1], position[2]}});
    }
    if (frames_.empty()) return fail(ErrorCode::kInvalid, "The file contains no labels.");
    return {};
  }

  /// Takes orientation and pixel size from the first frame, and checks that the others have the
  /// same.
  Result<void> check_same(const std::vector<double>& orientation,
                          const std::vector<double>& spacing) {
    if (frames_.empty()) {
      std::copy_n(orientation.begin(), 6, orientation_.begin());
      spacing_ = {spacing[0], spacing[1]};
      if (!dicom::make_axes(orientation_, axes_)) return damaged("its orientation is invalid");
      if (!(spacing_[0] > 0 && spacing_[1] > 0)) return damaged("its pixel size is invalid");
      return {};
    }
    constexpr double kTolerance = 1e-4;
    for (std::size_t i = 0; i < 6; ++i) {
      if (!(std::abs(orientation[i] - orientation_[i]) < kTolerance)) return mixed();
    }
    for (std::size_t i = 0; i < 2; ++i) {
      if (!(std::abs(spacing[i] - spacing_[i]) < kTolerance * spacing_[i])) return mixed();
    }
    return {};
  }
  static tl::unexpected<Error> mixed() {
    return fail(ErrorCode::kUnsupported,
                "The frames of this segmentation differ in orientation or pixel size, which is not "
                "supported.");
  }

  /// Returns the distance of planes in the file's header, or the least distance of two frames.
  double distance_of_planes(const std::vector<double>& heights) const {
    const DataSet& first = dicom::items_of(file_, kPerFrame).front();
    double least = 0;
    for (std::size_t i = 1; i < heights.size(); ++i) {
      const double gap = heights[i] - heights[i - 1];
      if (least == 0 || gap < least) least = gap;
    }
    for (const std::uint32_t tag : {kSliceSpacing, kThickness}) {
      const auto given = numbers(first, kMeasures, tag);
      // A thickness may exceed the distance of overlapping planes.
      const bool fits =
          given.size() == 1 && given[0] > 0 && (least == 0 || given[0] < 1.01 * least);
      if (fits) return given[0];
    }
    return least > 0 ? least : 1;
  }

  double height_of(const Frame& frame) const {
    return dicom::dot(dicom::minus(frame.position, frames_.front().position), axes_.normal);
  }

  /// Finds the planes, and the plane of each frame.
  Result<void> arrange() {
    std::vector<double> heights;
    constexpr double kSamePlane = 1e-3, kOffset = 0.01;  // mm; share of a pixel
    for (const Frame& frame : frames_) {
      heights.push_back(height_of(frame));
      const Vec3 from_first = dicom::minus(frame.position, frames_.front().position);
      if (!(std::abs(dicom::dot(from_first, axes_.row)) < kOffset * spacing_[1] + kSamePlane) ||
          !(std::abs(dicom::dot(from_first, axes_.column)) < kOffset * spacing_[0] + kSamePlane)) {
        return fail(ErrorCode::kUnsupported,
                    "The frames of this segmentation are not stacked along their normal, which is "
                    "not supported.");
      }
    }
    std::sort(heights.begin(), heights.end());
    const auto same = [](double a, double b) { return b - a < kSamePlane; };
    heights.erase(std::unique(heights.begin(), heights.end(), same), heights.end());
    const double step = distance_of_planes(heights);
    const double low = heights.front();
    const double planes = std::floor((heights.back() - low) / step + 0.5) + 1;
    const double most = static_cast<double>(limits_.voxels) / image_.size[0] / image_.size[1];
    if (!(planes <= most)) {
      return fail(ErrorCode::kTooLarge, "The segmentation has more voxels than allowed.");
    }
    image_.size[2] = static_cast<std::uint32_t>(planes);
    for (const Frame& frame : frames_) {
      const double plane = (height_of(frame) - low) / step;
      constexpr double kIrregular = 0.1;
      if (std::abs(plane - std::round(plane)) > kIrregular) {
        return fail(ErrorCode::kUnsupported,
                    "The frames of this segmentation are not evenly spaced, which is not "
                    "supported.");
      }
      planes_.push_back(static_cast<std::size_t>(std::lround(plane)));
    }
    place(step, low);
    return {};
  }

  void place(double step, double low) {
    const Vec3* columns[] = {&axes_.row, &axes_.column, &axes_.normal};
    const double steps[] = {spacing_[1], spacing_[0], step};
    image_.origin.emplace();
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        image_.axes[3 * row + axis] = (*columns[axis])[row] * steps[axis];
      }
      (*image_.origin)[row] = frames_.front().position[row] + low * axes_.normal[row];
    }
  }

  Result<void> read_pixels() {
    const dicom::DataElement* pixels = dicom::find(file_, dicom::kPixelData);
    const std::size_t area = std::size_t{image_.size[0]} * image_.size[1];
    const std::size_t numbers = area * frames_.size();
    const std::size_t bytes = fractional_ ? numbers : (numbers + 7) / 8;
    if (pixels == nullptr || pixels->value.size() < bytes) return damaged("pixels are missing");
    image_.voxels.resize(area * image_.size[2]);
    // The largest fraction so far in each voxel, of a fractional segmentation.
    std::vector<std::uint8_t> most(fractional_ ? image_.voxels.size() : 0);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      std::uint8_t* to = image_.voxels.data() + planes_[i] * area;
      for (std::size_t pixel = 0; pixel < area; ++pixel) {
        const std::size_t at = i * area + pixel;
        if (!fractional_) {
          // The first pixel is in the lowest bit (PS3.5, 8.1.1), and frames are not padded.
          const auto byte = std::to_integer<unsigned>(pixels->value[at / 8]);
          if ((byte >> (at % 8) & 1) != 0) to[pixel] = frames_[i].label;
          continue;
        }
        const auto value = std::to_integer<std::uint8_t>(pixels->value[at]);
        std::uint8_t& before = most[planes_[i] * area + pixel];
        if (2u * value < largest_ || value == 0 || value < before) continue;
        before = value;
        to[pixel] = frames_[i].label;
      }
    }
    return {};
  }

  const DataSet& file_;
  const LabelLimits& limits_;
  bool fractional_ = false;
  unsigned largest_ = 255;
  std::map<std::uint16_t, std::uint8_t> places_;  ///< place in the table, by segment number
  std::vector<Frame> frames_;
  std::vector<std::size_t> planes_;  ///< plane of each frame
  std::array<double, 6> orientation_{};
  std::array<double, 2> spacing_{};
  dicom::Axes axes_;
  LabelImage image_;
};

}  // namespace

Result<LabelImage> read_segmentation(const DataSet& file, const LabelLimits& limits) {
  return Segmentation(file, limits).read();
}

}  // namespace diaphane::ingest
