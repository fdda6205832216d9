#pragma once

#include "volume/labels.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// Labels the brain (Label::kBrain) in an MR scan of a head or in a scan that shows a brain alone.
/// A balloon is blown up within the head until it reaches the dark fluid around the brain (the
/// method of S. M. Smith, "Fast robust automated brain extraction", Human Brain Mapping 17, 2002).
/// Changes nothing if that shape is not plausible as a brain, and in CT and PET scans. `labels`
/// must come from label_body(). Returns whether a brain was found.
bool mark_brain(const volume::Volume& volume, volume::Labels& labels);

}  // namespace diaphane::ingest
