#pragma once

#include "renderd/bench/farm_wire.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::bench {

struct RendererOptions {
  std::uint64_t seed, first_sample;
  Method method;
};

/// Runs a process of a farm: creates an engine, loads the volume, and answers requests until the
/// other end closes the connection.
void serve_farm_device(const FarmWire& wire, EngineChoice choice, unsigned threads,
                       const volume::Volume& volume);

}  // namespace diaphane::render::bench
