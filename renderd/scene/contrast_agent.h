#pragma once

#include "volume/volume.h"

namespace diaphane::render {

/// Returns whether a CT shows vessels filled with contrast agent. It looks for cells of about 3 mm
/// that have the values of contrast agent everywhere and are not beside denser cells: spongy bone
/// has such values too, but lies within a dense shell. Returns true if these cells fill at least 1
/// ml. Spongy bone without a dense shell, as in some vertebrae, is taken for contrast agent.
bool shows_contrast_agent(const volume::Volume& volume);

}  // namespace diaphane::render
