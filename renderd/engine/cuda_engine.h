#pragma once

#include <memory>

#include "common/result.h"
#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// The CUDA engine on the first visible device (CUDA_VISIBLE_DEVICES chooses; one renderd a GPU).
/// kUnavailable when no device answers, or none that this program has code for. Only there when the
/// target `render_cuda` is (DIAPHANE_HAVE_CUDA).
Result<std::unique_ptr<Engine>> make_cuda_engine(const EngineOptions& options = {});

}  // namespace diaphane::render
