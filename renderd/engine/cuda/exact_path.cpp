#include "renderd/engine/cuda/exact_path.h"

#include <algorithm>

#include "common/try.h"

namespace diaphane::render::cuda {
namespace {

/// Maximum number of samples per launch. A larger number would not be faster.
constexpr std::uint64_t kMostSamples = 32;

ExactNeeds needs_of(const PreparedScene& scene) {
  ExactNeeds needs;
  const auto strata = strata_for(scene);
  for (int kind = 0; kind < kIndirect; ++kind) {
    needs.light_strata += static_cast<std::uint32_t>(strata[static_cast<std::size_t>(kind)]);
  }
  needs.indirect_strata = static_cast<std::uint32_t>(strata[kIndirect]);
  needs.glow = scene.features.has(Feature::kEmission);
  return needs;
}

}  // namespace

Result<void> ExactPath::reserve(const PreparedScene& scene) {
  const auto tiles = [](std::uint32_t length, std::uint32_t tile) {
    return std::uint64_t{(length + tile - 1) / tile};
  };
  const std::uint64_t row_items = tiles(scene.canvas.width, kTileWidth) * kTileWidth * kStripeRows;
  const std::uint64_t picture = tiles(scene.canvas.height, kStripeRows) * row_items;
  const std::uint64_t samples = std::clamp<std::uint64_t>(kExactItems / picture, 1, kMostSamples);
  const ExactNeeds needs = needs_of(scene);
  const auto room =
      workspace_->reserve(needs, std::min(picture * samples, kExactItems), row_items * samples);
  DIAPHANE_TRY(room);
  needs_ = needs;
  room_ = *room;
  row_items_ = row_items;
  samples_ = static_cast<std::uint32_t>(samples);
  return {};
}

Result<void> ExactPath::choose_kernels(VariantStore& variants, Features needed) {
  // The camera and light kernels do not track, and the gather kernel records the guides.
  const Features walked = needed.without(Feature::kGuides).without(Feature::kSteepExtinction);
  kernels_.camera = variants.get(kExactCamera, walked);
  kernels_.light = variants.get(kExactLight, walked.without(Feature::kBounces));
  kernels_.indirect = needs_.indirect_strata > 0
                          ? variants.get(kExactIndirect, needed.without(Feature::kGuides))
                          : nullptr;
  const auto blocks = light_blocks(*kernels_.light);
  DIAPHANE_TRY(blocks);
  light_blocks_ = *blocks;
  return {};
}

std::uint32_t ExactPath::rows(std::uint32_t samples) const {
  const std::uint64_t steps = room_ / (row_items_ * samples);
  return static_cast<std::uint32_t>(std::max<std::uint64_t>(steps, 1)) * kStripeRows;
}

Result<void> ExactPath::launch(const SceneView<TextureVolume>& scene, const Stripe& stripe,
                               const TraceTarget& target, cudaStream_t stream) const {
  const std::uint64_t items = std::uint64_t{kTilePixels} * stripe.samples *
                              tiles_of(scene.width, scene.height, stripe).per_sample();
  return workspace_->use(needs_, items, stream, [&](const ExactScratch& scratch) {
    return trace_exact(kernels_, scene, stripe, scratch, target, light_blocks_, stream);
  });
}

}  // namespace diaphane::render::cuda
