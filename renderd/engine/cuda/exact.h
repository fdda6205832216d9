#pragma once

#include <memory>

#include "renderd/engine/cuda/exact_types.h"
#include "renderd/engine/cuda/nvrtc.h"
#include "renderd/engine/cuda/variants.h"

namespace diaphane::render::cuda {

/// The kernels of the exact walk (exact_camera.cuh, exact_light.cuh), compiled into the program for
/// each of kVariants. Feature::kGuides does not affect them.
extern const KernelTemplate kExactCamera, kExactLight, kExactIndirect;

/// The kernel instances for one scene.
struct ExactKernels {
  std::shared_ptr<const Variant> camera, light;
  std::shared_ptr<const Variant> indirect;  ///< null without Feature::kBounces
};

/// Returns the number of blocks of the light kernel that run at once. Each launch has this size,
/// however much work there is.
Result<std::uint32_t> light_blocks(const Variant& light);

/// Queues one launch, which traces the stripe and adds it to the film. The scratch memory must have
/// room for it.
cudaError_t trace_exact(const ExactKernels& kernels, const SceneView<TextureVolume>& scene,
                        const Stripe& stripe, const ExactScratch& scratch,
                        const TraceTarget& target, std::uint32_t light_blocks, cudaStream_t stream);

}  // namespace diaphane::render::cuda
