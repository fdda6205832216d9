#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "volume/volume.h"

namespace diaphane::dicom {

enum class Kind {
  kImage,       ///< CT, MR or PT image storage
  kMultiFrame,  ///< their enhanced forms
  kOther,       ///< screenshots, reports, PDF, structure sets, segmentations, dose: no slices
};

/// How the stored numbers are packed (DICOM PS3.3, C.7.6.3).
struct PixelLayout {
  std::uint16_t bits_allocated = 16;
  std::uint16_t bits_stored = 16;
  std::uint16_t high_bit = 15;
  bool is_signed = false;
  bool operator==(const PixelLayout&) const = default;
};

/// From stored numbers to values: slope x stored + intercept.
struct Rescale {
  double slope = 1;
  double intercept = 0;
  bool present = false;
  bool operator==(const Rescale&) const = default;
};

/// What one file says about itself, as far as a volume depends on it. Identifiers serve to tell
/// slices apart while a folder is read; nothing of them is stored, logged or shown.
struct Slice {
  std::size_t file = 0;        ///< index in its FileSource
  std::size_t frame = 0;       ///< of a file with several
  bool one_of_frames = false;  ///< of an enhanced file, which says of each frame where it lies
  Kind kind = Kind::kOther;
  volume::Modality modality = volume::Modality::kOther;
  std::string patient, series_uid, sop_uid;
  std::string stack;  ///< frames of one stack lie behind one another; empty outside enhanced files
  std::vector<std::string> image_type;
  bool is_lossy = false;  ///< was compressed with loss, which alone makes it "DERIVED"
  std::uint16_t rows = 0, columns = 0;
  std::uint64_t frames = 1;  ///< more than one: several pictures without a place each
  std::uint16_t samples = 1;
  std::string photometric;
  PixelLayout layout;
  Rescale rescale;
  bool has_lookup_table = false;                 ///< a Modality LUT instead of slope and intercept
  std::optional<std::array<double, 2>> padding;  ///< stored values from - to that mean "no pixel"
  bool has_pixels = false;
  std::optional<std::array<double, 3>> position;       ///< mm, LPS
  std::optional<std::array<double, 6>> orientation;    ///< along a row, along a column
  std::optional<std::array<double, 2>> pixel_spacing;  ///< mm between rows, between columns
  double window_center = 0, window_width = 0;

  bool is_scout() const;
};

}  // namespace diaphane::dicom
