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
  kMultiFrame,  ///< enhanced CT, MR or PT image storage
  kOther,       ///< not slices: screenshots, reports, PDF, structure sets, segmentations, dose
};

/// How the stored numbers are packed (DICOM PS3.3, C.7.6.3).
struct PixelLayout {
  std::uint16_t bits_allocated = 16;
  std::uint16_t bits_stored = 16;
  std::uint16_t high_bit = 15;
  bool is_signed = false;
  bool operator==(const PixelLayout&) const = default;
};

/// Linear mapping from stored numbers to values: slope x stored + intercept.
struct Rescale {
  double slope = 1;
  double intercept = 0;
  bool present = false;
  bool operator==(const Rescale&) const = default;
};

/// What may distinguish slices at the same position, in the order of preference. The values of the
/// last five only give an order.
enum class Distinction : std::size_t {
  kBValue,       ///< s/mm²
  kEchoTime,     ///< ms
  kCycle,        ///< percent of a heartbeat
  kTriggerTime,  ///< ms since the heartbeat began
  kTimeOffset,   ///< ms
  kTemporalPosition,
  kImageType,
  kAcquisitionTime,
  kContentTime,
  kInstance,  ///< instance number
};
inline constexpr std::size_t kDistinctions = 10;

/// The contents of one file that a volume depends on. Identifiers only distinguish slices while a
/// folder is read. They are never stored, logged or shown.
struct Slice {
  std::size_t file = 0;        ///< index in its FileSource
  std::size_t frame = 0;       ///< index within a file of several frames
  bool one_of_frames = false;  ///< frame of an enhanced file, with its own position
  Kind kind = Kind::kOther;
  volume::Modality modality = volume::Modality::kOther;
  std::string patient, series_uid, sop_uid;
  std::string frame_of_reference;  ///< identifies the patient's space
  std::string
      stack;  ///< identifies frames that lie behind one another; empty outside enhanced files
  std::vector<std::string> image_type;
  bool is_lossy = false;  ///< lossy compression, which alone makes it "DERIVED"
  std::uint16_t rows = 0, columns = 0;
  std::uint64_t frames = 1;  ///< more than one: several images without individual positions
  std::uint16_t samples = 1;
  std::string photometric;
  PixelLayout layout;
  Rescale rescale;
  bool has_lookup_table = false;  ///< has a Modality LUT instead of slope and intercept
  std::optional<std::array<double, 2>> padding;  ///< range of stored values that mean "no pixel"
  bool has_pixels = false;
  std::optional<std::array<double, 3>> position;       ///< mm, LPS
  std::optional<std::array<double, 6>> orientation;    ///< along a row, along a column
  std::optional<std::array<double, 2>> pixel_spacing;  ///< mm between rows, between columns
  double window_center = 0, window_width = 0;          ///< in units of the values; width 0: unknown
  std::array<std::optional<double>, kDistinctions> moment;  ///< by Distinction

  std::optional<double>& by(Distinction one) { return moment[static_cast<std::size_t>(one)]; }

  bool is_scout() const;
};

}  // namespace diaphane::dicom
