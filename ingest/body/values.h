#pragma once

#include "volume/volume.h"

namespace diaphane::ingest {

/// What the values of a volume mean for telling matter from air.
struct ValueScale {
  bool hounsfield = false;  ///< values are Hounsfield units
  bool density = false;     ///< values rise with density, as in CT; tissue has no dark gaps
  bool noisy = false;       ///< some of the air is above `matter`
  int matter = 0;           ///< the least value of skin
  int foam = 0;             ///< the least mean value of a cell of foam; only for Hounsfield units
};

ValueScale value_scale(const volume::Volume& volume);

}  // namespace diaphane::ingest
