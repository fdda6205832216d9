#pragma once

#include "volume/volume.h"

namespace diaphane::render {

/// Whether a CT shows vessels filled with contrast agent. It looks for cells of about 3 mm that
/// have the values of contrast agent everywhere and are not beside denser cells: spongy bone has
/// such values too, but lies within a dense shell. Returns true if there are at least 1 ml of them.
/// Spongy bone without a dense shell is taken for contrast agent, as in some vertebrae.
bool shows_contrast_agent(const volume::Volume& volume);

}  // namespace diaphane::render
