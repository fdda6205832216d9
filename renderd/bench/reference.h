#pragma once

#include <functional>
#include <string>

#include "renderd/bench/picture_error.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::bench {

/// What the reference of a measurement is taken from, and where it is kept.
struct Subject {
  Engine* engine;
  std::shared_ptr<const DeviceVolume> volume;
  std::uint64_t voxels_hash = 0;  ///< hash_of the volume
  diaphane::v1::Scene scene;
  Canvas canvas;
};

std::uint64_t hash_of(const volume::Volume& volume);

struct ReferenceWish {
  double error;                                    ///< at most this, of its own
  double seconds;                                  ///< but not much longer than this
  std::string cache;                               ///< folder; empty: none
  bool fresh = false;                              ///< takes nothing from the cache
  std::function<void(const Reference&)> progress;  ///< may be empty
};

/// By tracking with independent points and a seed of its own: the plainest estimator there is. One
/// in the cache is refined by further samples, whose range does not overlap its own, until it is
/// good enough; which engine made it does not matter.
Result<Reference> reference_of(const Subject& subject, const ReferenceWish& wish);

}  // namespace diaphane::render::bench
