#include <cstdlib>

#include "common/try.h"
#include "renderd/engine/cpu/engine.h"
#include "renderd/engine/cpu/kernel.h"
#include "renderd/engine/frame_renderer.h"
#if defined(DIAPHANE_HAVE_CUDA)
#include "renderd/engine/cuda/engine.h"
#endif

namespace diaphane::render {
namespace {

Result<std::unique_ptr<Engine>> cuda_engine([[maybe_unused]] const EngineOptions& options) {
#if defined(DIAPHANE_HAVE_CUDA)
  return make_cuda_engine(options);
#else
  return fail(ErrorCode::kUnavailable, "this program was built without the CUDA engine", "engine");
#endif
}

Result<std::unique_ptr<Engine>> cpu_engine(unsigned threads, const EngineOptions& options,
                                           const std::string& fallback_reason) {
  if (!cpu_suffices()) {
    return fail(ErrorCode::kUnavailable,
                "This program was built for a CPU with AVX2, FMA and BMI2. Build it with "
                "-DDIAPHANE_PORTABLE=ON to run it here.");
  }
  return make_cpu_engine(threads, options.film_bytes, fallback_reason);
}

}  // namespace

std::string default_kernel_cache() {
  if (const char* chosen = std::getenv("DIAPHANE_KERNEL_CACHE")) return chosen;
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache == '/') {
    return std::string(cache) + "/diaphane/kernels";
  }
  if (const char* home = std::getenv("HOME"); home != nullptr && *home == '/') {
    return std::string(home) + "/.cache/diaphane/kernels";
  }
  return {};
}

std::optional<KernelChoice> kernel_choice(std::string_view name) {
  if (name == "exact") return KernelChoice::kExact;
  if (name == "stand-in") return KernelChoice::kStandIn;
  if (name == "ahead-of-time") return KernelChoice::kAheadOfTime;
  if (name == "general") return KernelChoice::kGeneral;
  return {};
}

Result<EngineOptions> engine_options_from_environment() {
  EngineOptions options;
  options.kernel_cache = default_kernel_cache();
  if (const char* name = std::getenv("DIAPHANE_KERNELS")) {
    const auto choice = kernel_choice(name);
    if (!choice) {
      return fail(ErrorCode::kInvalid, "must be exact, stand-in, ahead-of-time or general",
                  "DIAPHANE_KERNELS");
    }
    options.kernels = *choice;
  }
  if (const char* lean = std::getenv("DIAPHANE_LEAN_MEMORY")) {
    const std::string_view value(lean);
    if (value != "0" && value != "1") {
      return fail(ErrorCode::kInvalid, "must be 0 or 1", "DIAPHANE_LEAN_MEMORY");
    }
    options.lean_memory = value == "1";
  }
  return options;
}

int visible_devices() {
#if defined(DIAPHANE_HAVE_CUDA)
  return visible_cuda_devices();
#else
  return 0;
#endif
}

Result<std::unique_ptr<Engine>> make_engine(EngineChoice choice, unsigned threads,
                                            const EngineOptions& options,
                                            const FallbackReport& on_fallback) {
  if (choice != EngineChoice::kCpu) {
    auto engine = cuda_engine(options);
    if (engine || choice == EngineChoice::kCuda) return engine;
    if (on_fallback) {
      on_fallback(engine.error());
      return cpu_engine(threads, options, engine.error().message);
    }
  }
  return cpu_engine(threads, options, {});
}

Result<std::unique_ptr<Engine>> make_engine(EngineChoice choice, unsigned threads) {
  const auto options = engine_options_from_environment();
  DIAPHANE_TRY(options);
  return make_engine(choice, threads, *options);
}

}  // namespace diaphane::render
