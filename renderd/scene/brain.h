#pragma once

#include <optional>

#include "renderd/scene/framing.h"
#include "volume/volume.h"

namespace diaphane::render {

/// What the looks of the brain need to know about it.
struct BrainFacts {
  double value = 0;  ///< its median, between the values of grey and white matter in a T1 scan
  Framing framing;
};

/// Returns the facts about the brain that ingest has labelled (volume::Label::kBrain), or nullopt
/// if it found none.
std::optional<BrainFacts> brain_of(const volume::Volume& volume);

}  // namespace diaphane::render
