#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::cuda {

/// Smooth values from 0 to 1000 with structure along all axes, spacing 1 x 1.5 x 2 mm, turned axes.
volume::Volume lumpy_volume(std::uint32_t nx, std::uint32_t ny, std::uint32_t nz);

/// The same value everywhere, 1 mm voxels.
volume::Volume constant_volume(std::uint32_t n, std::int16_t value);

/// Two materials that overlap, two rectangle lights, sky, anisotropic phase: every feature of the
/// kernel.
diaphane::v1::Scene full_scene();

/// No light but a background of radiance 1, black matter: a pixel is the transmittance. The camera
/// is far off along z with a narrow field of view, so all rays are parallel to it within 1e-5.
diaphane::v1::Scene transmittance_scene(double extinction_per_mm);

/// |t| that a Student variable of `dof` >= 10 degrees of freedom exceeds with probability `p` (two
/// sides). Cornish-Fisher expansion of the normal quantile (Abramowitz and Stegun 26.7.5); relative
/// error below 1% for p >= 1e-9.
double critical_t(double p, double dof);

/// The significance each of `tests` independent tests needs for `alpha` in all (Sidak).
double sidak(double alpha, std::size_t tests);

Result<void> render_all(FrameRenderer& renderer, const diaphane::v1::Scene& scene, Canvas canvas,
                        std::uint32_t samples);
std::vector<float> radiance_of(FrameRenderer& renderer);

/// Skips where no device answers.
class CudaTest : public ::testing::Test {
 protected:
  void SetUp() override;

  std::unique_ptr<FrameRenderer> renderer(const std::shared_ptr<const DeviceVolume>& volume,
                                          std::uint64_t seed = 1);
  std::unique_ptr<Engine> engine_;
};

}  // namespace diaphane::render::cuda
