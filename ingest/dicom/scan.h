#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"
#include "ingest/dicom/classify.h"
#include "ingest/dicom/precheck.h"
#include "ingest/dicom/slice.h"
#include "ingest/dicom/source.h"

namespace diaphane::dicom {

/// One series of one patient, as found; of an enhanced file, one stack of it.
struct Series {
  std::vector<Slice> slices;
  Assessment assessment;
};

/// Files that are in no series, by reason.
struct LeftOut {
  std::size_t not_dicom = 0;
  std::size_t damaged = 0;
  std::size_t too_large = 0;
  std::size_t unsupported = 0;   ///< a compression that is not read
  std::size_t not_slices = 0;    ///< screenshots, reports, PDF, dose, segmentations: never listed
  std::string unsupported_text;  ///< of the first of them
  std::string too_large_text;
};

struct Scan {
  std::vector<Series> series;  ///< in the order of their first files
  LeftOut left_out;
  std::size_t files = 0;
};

struct ScanLimits {
  Limits file;
  std::uint64_t most_voxels = std::uint64_t{1} << 30;  ///< of one volume: 2 GiB of int16
  std::size_t most_files = 20000;                      ///< and slices
  /// What compressed files may become together: this much, and beyond it so many times their own
  /// length (real slices, lossless: 2 to 10 times), and never more than the last.
  std::uint64_t unpacked_free = std::uint64_t{1} << 27;
  std::uint32_t unpacked_ratio = 32;
  std::uint64_t unpacked_bytes = std::uint64_t{1} << 33;
};

/// Looks through all files: pre-check, header, series by identifier and patient, judgement of each.
/// kTooLarge for more files, or more that unpacks, than the limits; what `source` fails with.
Result<Scan> scan(FileSource& source, const ScanLimits& limits);

/// Why a scan yields no volume, or which series is the one: the single suitable series.
/// `index` is set with `suitable`. For an upload, which holds one series.
struct Choice {
  bool suitable = false;
  std::size_t index = 0;
  std::string code, text;
  std::vector<std::string> repairs;  ///< the series' own and files that were left out
};
Choice choose(const Scan& scan);

/// The same, where several are welcome: the suitable one with the most slices.
Choice choose_largest(const Scan& scan);

}  // namespace diaphane::dicom
