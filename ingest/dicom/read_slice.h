#pragma once

#include <vector>

#include "common/result.h"
#include "ingest/dicom/precheck.h"
#include "ingest/dicom/slice.h"
#include "ingest/dicom/values.h"

namespace diaphane::dicom {

/// Reads the slices of a file that passed the pre-check (`checked`): one slice, or one per frame of
/// an enhanced file. Returns kInvalid if GDCM cannot read it or finds another image size than the
/// pre-check.
Result<std::vector<Slice>> read_slices(const Precheck& checked);

/// Decodes the pixels of `slice`, which comes from read_slices, into values row by row from the top
/// (see to_values). Returns kInvalid if they cannot be decoded.
Result<Values> read_values(const Precheck& checked, const Slice& slice, double unit = 0);

}  // namespace diaphane::dicom
