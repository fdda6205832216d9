#pragma once

#include <cstdint>
#include <vector>

#include "common/result.h"
#include "ingest/dicom/precheck.h"
#include "ingest/dicom/slice.h"

namespace diaphane::dicom {

/// Reads the elements of Slice from a file that passed the pre-check (`checked`), up to the pixels.
/// kInvalid when GDCM cannot read it or sees another picture than the pre-check did.
Result<Slice> read_slice(const Precheck& checked);

/// Decodes the pixels of a file whose Slice is `slice`, and gives its values, row by row from the
/// top: Hounsfield units for CT, stored units otherwise (see to_values). kInvalid when they cannot
/// be decoded.
Result<std::vector<std::int32_t>> read_values(const Precheck& checked, const Slice& slice);

}  // namespace diaphane::dicom
