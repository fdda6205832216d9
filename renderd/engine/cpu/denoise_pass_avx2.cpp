#include "renderd/engine/cpu/denoise_pass.inc"

namespace diaphane::render {

void denoise_row_avx2(const DenoisePlanes& planes, std::int32_t y, std::int32_t stride, float voxel,
                      float* scratch) {
  denoise_row_here(planes, y, stride, voxel, scratch);
}

}  // namespace diaphane::render
