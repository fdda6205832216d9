#pragma once

#include "bench/renderer/process_wire.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::bench {

struct RendererOptions {
  std::uint64_t seed, first_sample;
  Method method;
};

/// Runs one device process of a MultiProcessEngine: creates an engine, loads the volume, and
/// answers requests until the other end closes the connection.
void serve_device_process(const ProcessWire& wire, EngineChoice choice, unsigned threads,
                          const volume::Volume& volume);

}  // namespace diaphane::render::bench
