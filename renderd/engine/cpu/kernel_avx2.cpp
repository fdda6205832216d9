#include "renderd/engine/cpu/kernel.inc"

namespace diaphane::render {

CpuKernel cpu_kernel_avx2(Features features, bool exact) { return variant(features, exact); }

}  // namespace diaphane::render
