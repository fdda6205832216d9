#pragma once

#include <functional>
#include <string>

#include "bench/renderer/picture_error.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::bench {

/// The subject of a measurement, from which its reference is rendered.
struct Subject {
  Engine* engine;
  std::shared_ptr<const DeviceVolume> volume;
  std::uint64_t voxels_hash = 0;  ///< hash_of() of the volume
  diaphane::v1::Scene scene;
  Canvas canvas;
};

std::uint64_t hash_of(const volume::Volume& volume);

struct ReferenceOptions {
  double error;                                    ///< target error of the reference
  double seconds;                                  ///< approximate limit on the time
  std::string cache;                               ///< folder of cached references; empty: none
  bool fresh = false;                              ///< ignores cached references
  std::function<void(const Reference&)> progress;  ///< may be empty
};

/// Renders by tracking with independent points and its own seed, which is the simplest estimator. A
/// cached reference is refined with samples from a disjoint range until it is good enough. It may
/// come from any engine.
Result<Reference> reference_of(const Subject& subject, const ReferenceOptions& options);

}  // namespace diaphane::render::bench
