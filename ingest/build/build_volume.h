#pragma once

#include "common/result.h"
#include "ingest/dicom/scan.h"
#include "ingest/dicom/source.h"
#include "volume/volume.h"

namespace diaphane::ingest {

struct Built {
  volume::Volume volume;  ///< with measured statistics
  volume::Filler filler;  ///< counts the voxels set to air because no pixel covers them
};

/// Builds the volume of series `choice.index` of `scan`. Decodes each slice into its place,
/// converts values with dicom::to_values, clamps them to int16, and resamples where the slices do
/// not form a regular volume. Returns kInvalid if a slice cannot be decoded, kUnsupported if many
/// values do not fit into 16 bits, kOutOfMemory, or an error of `source`. Precondition:
/// `choice.suitable`, and `source` still has the files that `scan` was made from.
Result<Built> build_volume(dicom::FileSource& source, const dicom::Scan& scan,
                           const dicom::Choice& choice, const dicom::Limits& limits);

}  // namespace diaphane::ingest
