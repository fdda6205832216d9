#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// Makes the engine that renders on the machine's cores. `threads` is the number of threads; 0
/// means one per core. The same scene, seed and number of samples give the same picture bit for
/// bit, whatever the number of threads and however the samples were divided into calls.
///
/// The pictures of all its renderers together take at most `film_bytes`; 0 means a quarter of the
/// memory that this process may use. set_scene() fails with kOutOfMemory beyond this limit.
///
/// `no_gpu` is the reason why this engine is used instead of a GPU. It becomes part of
/// EngineInfo::device, so that everyone who sees the device also sees the reason.
std::unique_ptr<Engine> make_cpu_engine(unsigned threads, std::uint64_t film_bytes = 0,
                                        std::string no_gpu = {});

}  // namespace diaphane::render
