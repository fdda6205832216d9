#pragma once

#include <string>

#include "ingest/dicom/scan.h"

namespace diaphane::scan {

/// A report for people, with one paragraph per series and suitable series first. It contains no
/// text from the files.
std::string as_text(const dicom::Scan& scan);

/// A report for programs: {files, series: [{suitable, modality, files, slices, size, spacing_mm,
/// direction, origin_mm, plane, phases: null | {by, values}, repairs, reason: null | {code,
/// text}}], left_out: {not_dicom, damaged, too_large, unsupported, not_slices}, upload: {suitable,
/// code, text, repairs}}. size, spacing_mm, direction, origin_mm and plane are null for a series
/// that is not suitable, and an unknown origin contains null. upload is the result for all files
/// sent as one upload.
std::string as_json(const dicom::Scan& scan);

}  // namespace diaphane::scan
