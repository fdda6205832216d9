#pragma once

#include <memory>

#include "common/result.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// Makes the CUDA engine on the visible device `options.device`. Fails with kUnavailable if the
/// device does not exist or the program contains no code for it, and with kOutOfMemory if the
/// device has too little free memory. The message names the device and the cause. This function
/// exists only in builds with the target `render_cuda` (DIAPHANE_HAVE_CUDA).
Result<std::unique_ptr<Engine>> make_cuda_engine(const EngineOptions& options = {});

/// Returns the number of visible devices, or 0 if the driver cannot be used.
int visible_cuda_devices();

}  // namespace diaphane::render
