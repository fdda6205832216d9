#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"

namespace diaphane::dicom {

/// A data element given by its bytes, for tests or samples that need unusual elements.
struct ExtraElement {
  std::uint16_t group = 0;
  std::uint16_t element = 0;
  std::string vr;     ///< "LO", "US", ...; "SQ": one item that holds `items`
  std::string value;  ///< raw bytes, little endian; the writer pads them to even length
  std::vector<ExtraElement> items;
};

/// Returns the little-endian bytes of a number, for ExtraElement::value.
std::string us(std::uint16_t value);

/// Attributes that all slices of a series share. The defaults describe a plain CT.
struct SeriesSpec {
  std::string sop_class = "1.2.840.10008.5.1.4.1.1.2";  ///< CT Image Storage
  std::string transfer_syntax = "1.2.840.10008.1.2.1";  ///< explicit VR little endian
  std::string modality = "CT";
  std::string image_type = "ORIGINAL\\PRIMARY\\AXIAL";        ///< not written if empty
  std::string study_uid, series_uid, frame_of_reference_uid;  ///< see new_uid()
  std::uint16_t rows = 0, columns = 0;
  std::array<double, 2> pixel_spacing{1, 1};  ///< mm: between rows, between columns
  std::array<double, 6> orientation{1, 0, 0,
                                    0, 1, 0};  ///< directions of a row and of a column (LPS)
  double slice_thickness = 1;                  ///< mm
  bool with_geometry = true;                   ///< false: no position, no orientation
  std::string photometric = "MONOCHROME2";
  std::uint16_t samples = 1;
  std::uint16_t bits_allocated = 16, bits_stored = 16, high_bit = 15;
  std::uint16_t is_signed = 1;
  bool with_rescale = true;
  double slope = 1, intercept = 0;                ///< value = slope x stored + intercept
  double window_center = 40, window_width = 400;  ///< in units of the values
  /// Adds every element of an invented patient, of institutions and of descriptions, including
  /// nested and private ones.
  bool with_patient = true;
  std::vector<ExtraElement> extra;
};

struct SliceSpec {
  std::array<double, 3> position{};  ///< mm (LPS), centre of the first pixel
  int instance_number = 1;
  std::string sop_uid;               ///< generated if empty
  std::vector<std::uint8_t> pixels;  ///< stored values: little endian, rows from the top
  std::vector<ExtraElement> extra;
};

/// The invented patient. Every text about them in a file of `write_slice` contains kCanary: in
/// elements, nested sequences, private elements, the preamble, an overlay, and after the pixels.
inline constexpr const char* kCanary = "Canary7f3a";
inline constexpr const char* kCanaryName = "Mustermann^Canary7f3a";

/// Returns "2.25." and a random 128-bit number (DICOM PS3.5, B.2).
std::string new_uid();

/// Returns the bytes of one DICOM file, or kInvalid if GDCM rejects it.
Result<std::string> write_slice(const SeriesSpec& series, const SliceSpec& slice);
/// Writes the bytes of write_slice to a file. Returns kUnavailable if that fails.
Result<void> write_slice_file(const SeriesSpec& series, const SliceSpec& slice,
                              const std::string& path);

}  // namespace diaphane::dicom
