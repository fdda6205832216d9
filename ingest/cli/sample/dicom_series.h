#pragma once

#include <functional>
#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::sample {

/// `volume` as a CT series of a made-up patient (ingest/dicom/series_writer.h, kCanary), one file a
/// slice, explicit VR little endian, stored unsigned with an intercept of -1024 as most scanners
/// do. Slices come in an order that only their positions tell. `take` gets each file's bytes.
Result<void> write_series(const volume::Volume& volume,
                          const std::function<Result<void>(const std::string& file)>& take);

/// The same into `directory` (made if need be), as one.dcm-like names without meaning.
Result<void> write_series_folder(const volume::Volume& volume, const std::string& directory);

}  // namespace diaphane::sample
