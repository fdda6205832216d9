#pragma once

#include <memory>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// Renders on the machine's cores. `threads` 0: all of them. The same scene, seed and number of
/// samples give the same picture bit for bit whatever the number of threads and however the samples
/// were asked for.
std::unique_ptr<Engine> make_cpu_engine(unsigned threads);

}  // namespace diaphane::render
