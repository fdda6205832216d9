#pragma once

#include <string>

#include "volume/labels.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// Labels the patient, their supports (table, headrest, frame, straps) and metal. If in doubt,
/// matter belongs to the body. The body includes the air that it encloses, and extends at least 1
/// mm into the air around it, so that a renderer that hides all other voxels leaves the skin
/// untouched. A PET scan is entirely body. Precondition: the volume is measured (volume::measure).
volume::Labels label_body(const volume::Volume& volume);

/// Returns all labels that a stored scan gets, encoded: those of label_body(), mark_brain() and
/// mark_structures(). If the volume holds several phases, what is body in any of them is body. Its
/// parts are those of the first phase, because the labels of a scan do not move.
std::string found_labels(const volume::Volume& volume);

}  // namespace diaphane::ingest
