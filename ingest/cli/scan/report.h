#pragma once

#include <string>

#include "ingest/dicom/scan.h"

namespace diaphane::scan {

/// For a person: one paragraph a series, the suitable ones first. No text of the files is in it.
std::string as_text(const dicom::Scan& scan);

/// For a program:
/// {files, series: [{suitable, modality, files, slices, size, spacing_mm, direction, origin_mm,
///   plane, repairs, reason: null | {code, text}}], left_out: {not_dicom, damaged, too_large,
///   unsupported, not_slices}, upload: {suitable, code, text, repairs}}
/// size, spacing_mm, direction, origin_mm and plane are null where the series is not suitable.
/// upload: what would be said of all the files sent as one upload.
std::string as_json(const dicom::Scan& scan);

}  // namespace diaphane::scan
