#pragma once

#include <functional>
#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::sample {

/// Writes `volume` as a CT series of an invented patient (ingest/dicom/series_writer.h, kCanary),
/// one file per slice, in explicit VR little endian. Values are unsigned with an intercept of
/// -1024, as on most scanners. The order of the slices can only be derived from their positions.
/// `take` receives the bytes of each file.
Result<void> write_series(const volume::Volume& volume,
                          const std::function<Result<void>(const std::string& file)>& take);

/// Writes the same files into `directory`, which is created if needed, under names without meaning.
Result<void> write_series_folder(const volume::Volume& volume, const std::string& directory);

}  // namespace diaphane::sample
