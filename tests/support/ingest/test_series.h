#pragma once

// Series of generated DICOM files in memory, for tests.

#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "ingest/dicom/scan.h"
#include "ingest/dicom/series_writer.h"
#include "ingest/dicom/source.h"

namespace diaphane::dicom::testing {

class MemorySource final : public FileSource {
 public:
  explicit MemorySource(std::vector<std::string> files) : files_(std::move(files)) {}
  Result<void> visit(const Want& want, const Take& take) override {
    for (std::size_t i = 0; i < files_.size(); ++i) {
      if (!want(i)) continue;
      if (auto ok = take(i, std::as_bytes(std::span(files_[i]))); !ok) return ok;
    }
    return {};
  }
  std::vector<std::string>& files() { return files_; }

 private:
  std::vector<std::string> files_;
};

/// The value (HU) of the generated image. It differs between neighbouring voxels and along every
/// axis, so that tests detect any rotation or shift.
inline int value_at(int x, int y, int z) { return -900 + 3 * x + 40 * y + 11 * z; }

struct Options {
  int columns = 12, rows = 10, slices = 20;
  double spacing = 2;                           ///< mm along the normal
  std::array<double, 3> origin{-10, 20, -300};  ///< of slice 0
  std::array<double, 3> step{0, 0, 1};          ///< direction from slice to slice
  std::function<double(int)> place;             ///< mm along `step`; empty: z x spacing
  SeriesSpec series;
  std::function<void(int, SeriesSpec&, SliceSpec&)> change;  ///< changes one slice
};

inline Options plain_ct() {
  Options options;
  options.series.study_uid = new_uid();
  options.series.series_uid = new_uid();
  options.series.frame_of_reference_uid = new_uid();
  options.series.pixel_spacing = {0.8, 0.7};
  options.series.bits_stored = 12;
  options.series.high_bit = 11;
  options.series.is_signed = 0;
  options.series.intercept = -1024;
  options.series.with_patient = false;
  return options;
}

/// Returns the stored pixels of slice z in the layout of `series` (8 or 16 bits), inverted for
/// MONOCHROME1 unless it is a CT.
inline std::vector<std::uint8_t> pixels_of(const Options& options, const SeriesSpec& series,
                                           int z) {
  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < options.rows; ++y) {
    for (int x = 0; x < options.columns; ++x) {
      long stored = std::lround((value_at(x, y, z) - series.intercept) / series.slope);
      if (series.photometric == "MONOCHROME1" && series.modality != "CT") {
        stored = series.is_signed ? -1 - stored : (1L << series.bits_stored) - 1 - stored;
      }
      const int shift = series.high_bit + 1 - series.bits_stored;
      const auto bits = static_cast<std::uint32_t>(stored) & ((1u << series.bits_stored) - 1);
      pixels.push_back(static_cast<std::uint8_t>(bits << shift));
      if (series.bits_allocated == 16)
        pixels.push_back(static_cast<std::uint8_t>(bits << shift >> 8));
    }
  }
  return pixels;
}

/// Returns the files in an order that carries no information.
inline std::vector<std::string> files_of(const Options& options) {
  std::vector<std::string> files;
  for (int n = 0; n < options.slices; ++n) {
    const int z = (7 * n + 3) %
                  options.slices;  // a permutation unless the number of slices is a multiple of 7
    SeriesSpec series = options.series;
    series.columns = static_cast<std::uint16_t>(options.columns);
    series.rows = static_cast<std::uint16_t>(options.rows);
    SliceSpec slice;
    slice.instance_number = n + 1;
    const double along = options.place ? options.place(z) : z * options.spacing;
    for (std::size_t i = 0; i < 3; ++i)
      slice.position[i] = options.origin[i] + along * options.step[i];
    slice.pixels = pixels_of(options, series, z);
    if (options.change) options.change(z, series, slice);
    auto file = write_slice(series, slice);
    if (!file) throw std::runtime_error(file.error().message);
    files.push_back(std::move(*file));
  }
  return files;
}

inline Scan scan_of(std::vector<std::string> files, const ScanLimits& limits = {}) {
  MemorySource source(std::move(files));
  auto found = scan(source, limits);
  if (!found) throw std::runtime_error(found.error().message);
  return std::move(*found);
}

}  // namespace diaphane::dicom::testing
