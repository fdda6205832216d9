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

/// One series of one patient, or one stack of an enhanced file.
struct Series {
  std::vector<Slice> slices;
  Assessment assessment;
};

/// Counts of files that belong to no series, by reason.
struct LeftOut {
  std::size_t not_dicom = 0;
  std::size_t damaged = 0;
  std::size_t too_large = 0;
  std::size_t unsupported = 0;   ///< a compression that is not supported
  std::size_t not_slices = 0;    ///< screenshots, reports, PDF, dose, segmentations; not listed
  std::string unsupported_text;  ///< reason for the first of them
  std::string too_large_text;
};

struct Scan {
  std::vector<Series> series;  ///< in the order of their first files
  LeftOut left_out;
  std::size_t files = 0;
};

struct ScanLimits {
  Limits file;
  std::uint64_t most_voxels = std::uint64_t{1} << 30;  ///< per volume: 2 GiB of int16
  std::size_t most_files = 20000;                      ///< maximum of files, and of slices
  /// Limit for the total unpacked size of compressed files: `unpacked_free` plus `unpacked_ratio`
  /// times their packed size (real lossless slices: 2 to 10 times), but at most `unpacked_bytes`.
  std::uint64_t unpacked_free = std::uint64_t{1} << 27;
  std::uint32_t unpacked_ratio = 32;
  std::uint64_t unpacked_bytes = std::uint64_t{1} << 33;
};

/// Reads all files, groups their slices into series by identifier and patient, and judges each
/// series. Returns kTooLarge if the files, or their unpacked size, exceed the limits. Also returns
/// the errors of `source`.
Result<Scan> scan(FileSource& source, const ScanLimits& limits);

/// The only suitable series of an upload, which contains one series, or the reason why there is
/// none. `index` is valid with `suitable`.
struct Choice {
  bool suitable = false;
  std::size_t index = 0;
  std::string code, text;
  std::vector<std::string> repairs;  ///< repairs of the series, and omitted files
};
Choice choose(const Scan& scan);

/// Chooses the suitable series with the most slices, for scans with several.
Choice choose_largest(const Scan& scan);

}  // namespace diaphane::dicom
