#include "renderd/engine/cpu_engine.h"
#include "renderd/engine/frame_renderer.h"
#if defined(DIAPHANE_HAVE_CUDA)
#include "renderd/engine/cuda_engine.h"
#endif

namespace diaphane::render {
namespace {

Result<std::unique_ptr<Engine>> cuda_engine() {
#if defined(DIAPHANE_HAVE_CUDA)
  return make_cuda_engine();
#else
  return fail(ErrorCode::kUnavailable, "this build has no CUDA engine", "engine");
#endif
}

}  // namespace

Result<std::unique_ptr<Engine>> make_engine(EngineChoice choice, unsigned threads) {
  if (choice != EngineChoice::kCpu) {
    auto engine = cuda_engine();
    if (engine || choice == EngineChoice::kCuda) return engine;
  }
  return make_cpu_engine(threads);
}

}  // namespace diaphane::render
