#pragma once

#include <memory>

#include "renderd/engine/cuda_exact_types.h"
#include "renderd/engine/cuda_nvrtc.h"
#include "renderd/engine/cuda_variants.h"

namespace diaphane::render::cuda {

/// The exact walk's kernels (cuda_exact_camera.cuh, cuda_exact_light.cuh); in the program for each
/// of kVariants. Features::kGuides is nothing to them.
extern const KernelTemplate kExactCamera, kExactLight, kExactOnwards;

/// Instances for one scene.
struct ExactKernels {
  std::shared_ptr<const Variant> camera, light;
  std::shared_ptr<const Variant> onwards;  ///< null without Feature::kBounces
};

/// Blocks of the light kernel that run at a time: it is launched with so many, whatever there is to
/// do.
Result<std::uint32_t> light_blocks(const Variant& light);

/// Queues one launch: traces the stripe and adds it to the film. The scratch has room for it.
cudaError_t trace_exact(const ExactKernels& kernels, const SceneView<TextureVolume>& scene,
                        const Stripe& stripe, const ExactScratch& scratch,
                        const TraceTarget& target, std::uint32_t light_blocks, cudaStream_t stream);

}  // namespace diaphane::render::cuda
