#include "renderd/engine/cpu/kernel.h"

#include "renderd/engine/cpu/denoise_pass.h"

namespace diaphane::render {
namespace {

bool has_avx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
         __builtin_cpu_supports("bmi2");
#else
  return false;
#endif
}

}  // namespace

CpuKernel cpu_kernel(Features features, bool exact) {
#if !defined(DIAPHANE_ONLY_AVX2)
  if (!has_avx2()) return cpu_kernel_baseline(features, exact);
#endif
#if defined(__x86_64__)
  return cpu_kernel_avx2(features, exact);
#else
  return nullptr;  // has_avx2() is false
#endif
}

bool cpu_suffices() {
#if defined(DIAPHANE_ONLY_AVX2)
  return has_avx2();
#else
  return true;
#endif
}

DenoiseRow denoise_row() {
#if defined(__x86_64__)
  if (has_avx2()) return denoise_row_avx2;
#endif
  return denoise_row_baseline;
}

const char* cpu_instructions() { return has_avx2() ? "AVX2" : "baseline"; }

}  // namespace diaphane::render
