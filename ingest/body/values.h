#pragma once

#include "volume/volume.h"

namespace diaphane::ingest {

/// Thresholds that separate matter from air in the values of a volume.
struct ValueScale {
  bool hounsfield = false;  ///< values are Hounsfield units
  bool density = false;     ///< values rise with density, as in CT; tissue has no dark gaps
  bool noisy = false;       ///< air has noise, some of which may be above `matter`
  int matter = 0;           ///< minimum value of skin
  int foam = 0;             ///< minimum mean value of a cell of foam; only for Hounsfield units
};

/// Returns whether the values are Hounsfield units, as far as the header shows.
bool is_hounsfield(const volume::Header& header);

ValueScale value_scale(const volume::Volume& volume);

}  // namespace diaphane::ingest
