#pragma once

#include <memory>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::bench {

/// Creates an engine of several devices, each in its own process like a worker, to measure the gain
/// of more devices. Device k uses the k-th CUDA device that is visible to this process, or its part
/// of the CPU's threads. A picture's samples are distributed in disjoint ranges, and the pictures
/// are merged with weights by count. Supports one volume and one renderer at a time.
///
/// Must be called before this process creates threads or uses CUDA.
Result<std::unique_ptr<Engine>> make_multi_process_engine(EngineChoice choice, unsigned devices,
                                                          unsigned threads);

}  // namespace diaphane::render::bench
