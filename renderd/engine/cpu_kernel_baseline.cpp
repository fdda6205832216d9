#include "renderd/engine/cpu_kernel.inc"

namespace diaphane::render {

CpuKernel cpu_kernel_baseline(Features features) { return variant(features); }

}  // namespace diaphane::render
