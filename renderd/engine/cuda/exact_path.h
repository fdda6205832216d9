#pragma once

#include <memory>

#include "renderd/engine/cuda/exact.h"
#include "renderd/engine/cuda/exact_scratch.h"
#include "renderd/film/canvas.h"
#include "renderd/scene/prepared_scene.h"

namespace diaphane::render::cuda {

/// Renders one session's scene by the exact walk. Chooses kernels, launch sizes and memory.
class ExactPath {
 public:
  explicit ExactPath(std::shared_ptr<ExactWorkspace> workspace)
      : workspace_(std::move(workspace)) {}

  /// Reserves memory for the launches of the scene. After kOutOfMemory, nothing has changed.
  Result<void> reserve(const PreparedScene& scene);
  /// Chooses the best available kernels for these features (VariantStore::get).
  Result<void> choose_kernels(VariantStore& variants, Features needed);
  /// Returns the kernel that does most of the work.
  const Variant& variant() const { return *kernels_.light; }

  std::uint64_t shared_bytes() const { return workspace_->device_bytes(); }

  /// Returns the maximum number of paths that continue from the collisions of a sample.
  std::uint32_t paths() const { return needs_.indirect_strata; }

  /// Returns the maximum number of samples per pixel in one launch.
  std::uint32_t samples() const { return samples_; }
  /// Returns the maximum rows of a launch of `samples` samples; a multiple of kStripeRows.
  std::uint32_t rows(std::uint32_t samples) const;
  Result<void> launch(const SceneView<TextureVolume>& scene, const Stripe& stripe,
                      const TraceTarget& target, cudaStream_t stream) const;

 private:
  std::shared_ptr<ExactWorkspace> workspace_;
  ExactNeeds needs_;
  std::uint64_t room_ = 0;       ///< number of items for which memory is reserved
  std::uint64_t row_items_ = 0;  ///< items in kStripeRows rows of one sample
  std::uint32_t samples_ = 1;
  ExactKernels kernels_;
  std::uint32_t light_blocks_ = 1;
};

}  // namespace diaphane::render::cuda
