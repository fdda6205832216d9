#pragma once

#include "common/result.h"
#include "ingest/dicom/scan.h"
#include "ingest/dicom/source.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// The volume of the series `choice.index` of `scan`, as a measured Volume: each slice decoded into
/// its place of a VTK image, values as dicom::to_values gives them, clamped to int16. kInvalid when
/// a slice cannot be decoded; kOutOfMemory; what `source` fails with. Precondition:
/// `choice.suitable`, and `source` has the files that it had when `scan` was made.
Result<volume::Volume> build_volume(dicom::FileSource& source, const dicom::Scan& scan,
                                    const dicom::Choice& choice, const dicom::Limits& limits);

}  // namespace diaphane::ingest
