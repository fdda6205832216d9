#include "renderd/engine/cpu/kernel.inc"

namespace diaphane::render {

CpuKernel cpu_kernel_baseline(Features features, bool exact) { return variant(features, exact); }

}  // namespace diaphane::render
