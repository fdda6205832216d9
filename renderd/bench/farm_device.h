#pragma once

#include "renderd/bench/farm_wire.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::bench {

struct RendererWish {
  std::uint64_t seed, first_sample;
  Method method;
};

/// What a process of a farm does: makes an engine, loads the volume, and answers until the other
/// end hangs up.
void serve_farm_device(const FarmWire& wire, EngineChoice choice, unsigned threads,
                       const volume::Volume& volume);

}  // namespace diaphane::render::bench
