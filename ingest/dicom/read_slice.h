#pragma once

#include <vector>

#include "common/result.h"
#include "ingest/dicom/precheck.h"
#include "ingest/dicom/slice.h"
#include "ingest/dicom/values.h"

namespace diaphane::dicom {

/// What a file that passed the pre-check (`checked`) says of its slices: one, or of an enhanced
/// file one a frame. kInvalid when GDCM cannot read it or sees another picture than the pre-check
/// did.
Result<std::vector<Slice>> read_slices(const Precheck& checked);

/// Decodes the pixels of `slice`, one of those that read_slices gave, into values row by row from
/// the top (see to_values). kInvalid when they cannot be decoded.
Result<Values> read_values(const Precheck& checked, const Slice& slice, double unit = 0);

}  // namespace diaphane::dicom
