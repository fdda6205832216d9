#pragma once

#include <memory>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::bench {

/// An engine made of several devices, each in a process of its own, as workers are: for measuring
/// what more devices give. Device k sees the k-th CUDA device that this process may see, or its
/// part of the CPU's threads. A picture's samples are spread over them in ranges that never
/// overlap, and the pictures are merged weighted by count. One volume and one renderer at a time.
///
/// Must be made before this process has threads or has touched CUDA.
Result<std::unique_ptr<Engine>> make_farm(EngineChoice choice, unsigned devices, unsigned threads);

}  // namespace diaphane::render::bench
