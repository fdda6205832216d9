#pragma once

#include <memory>

#include "renderd/engine/cuda_exact.h"
#include "renderd/engine/cuda_exact_scratch.h"
#include "renderd/film/canvas.h"
#include "renderd/scene/prepared_scene.h"

namespace diaphane::render::cuda {

/// Renders one session's scene by the exact walk: which kernels, in which portions, in what memory.
class ExactPath {
 public:
  explicit ExactPath(std::shared_ptr<ExactWorkspace> workspace)
      : workspace_(std::move(workspace)) {}

  /// Room for the scene's launches. kOutOfMemory harms nothing.
  Result<void> reserve(const PreparedScene& scene);
  /// The best kernels there are now.
  Result<void> choose_kernels(VariantStore& variants, Features needed);
  /// What does most of the work.
  const Variant& variant() const { return *kernels_.light; }

  std::uint64_t shared_bytes() const { return workspace_->device_bytes(); }

  /// That go on from a sample's collisions.
  std::uint32_t paths() const { return needs_.onwards_strata; }

  /// Of a pixel in one launch at most.
  std::uint32_t samples() const { return samples_; }
  /// Of a launch of so many samples at most; a multiple of kStripeRows.
  std::uint32_t rows(std::uint32_t samples) const;
  Result<void> launch(const SceneView<TextureVolume>& scene, const Stripe& stripe,
                      const TraceTarget& target, cudaStream_t stream) const;

 private:
  std::shared_ptr<ExactWorkspace> workspace_;
  ExactNeeds needs_;
  std::uint64_t room_ = 0;       ///< items
  std::uint64_t row_items_ = 0;  ///< of kStripeRows rows of one sample
  std::uint32_t samples_ = 1;
  ExactKernels kernels_;
  std::uint32_t light_blocks_ = 1;
};

}  // namespace diaphane::render::cuda
