#pragma once

#include "common/result.h"
#include "ingest/dicom/scan.h"
#include "ingest/dicom/source.h"
#include "volume/volume.h"

namespace diaphane::ingest {

struct Built {
  volume::Volume volume;  ///< measured
  volume::Filler filler;  ///< voxels of it that are air because nothing was there
};

/// The volume of the series `choice.index` of `scan`: each slice decoded into its place, values as
/// dicom::to_values gives them, clamped to int16, then resampled where the slices alone are no
/// volume. kInvalid when a slice cannot be decoded; kUnsupported when many values do not fit into
/// 16 bits; kOutOfMemory; what `source` fails with.
/// Precondition: `choice.suitable`, and `source` has the files that it had when `scan` was made.
Result<Built> build_volume(dicom::FileSource& source, const dicom::Scan& scan,
                           const dicom::Choice& choice, const dicom::Limits& limits);

}  // namespace diaphane::ingest
