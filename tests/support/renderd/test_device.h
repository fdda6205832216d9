#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render::cuda {

/// Smooth values from 0 to 1000 that vary along all axes, with a spacing of 1 x 1.5 x 2 mm and
/// rotated axes.
volume::Volume lumpy_volume(std::uint32_t nx, std::uint32_t ny, std::uint32_t nz);

/// The same value everywhere, with voxels of 1 mm.
volume::Volume constant_volume(std::uint32_t n, std::int16_t value);

/// A scene that needs every feature of the kernel: two overlapping materials, two rectangle lights,
/// a sky and an anisotropic phase function.
diaphane::v1::Scene full_scene();

/// Black matter before a background of radiance 1, with no other light, so that a pixel is the
/// transmittance. The camera is far away along z with a narrow field of view, so all rays are
/// parallel to z within 1e-5.
diaphane::v1::Scene transmittance_scene(double extinction_per_mm);

/// Returns the |t| that a Student variable of `dof` >= 10 degrees of freedom exceeds with
/// probability `p` (two-sided). It uses the Cornish-Fisher expansion of the normal quantile
/// (Abramowitz and Stegun 26.7.5), whose relative error is below 1% for p >= 1e-9.
double critical_t(double p, double dof);

/// Returns the significance that each of `tests` independent tests may have for a total of `alpha`
/// (Sidak).
double sidak(double alpha, std::size_t tests);

Result<void> render_all(FrameRenderer& renderer, const diaphane::v1::Scene& scene, Canvas canvas,
                        std::uint32_t samples);
std::vector<float> radiance_of(FrameRenderer& renderer);

/// Skips its tests if no device is available.
class CudaTest : public ::testing::Test {
 protected:
  void SetUp() override;

  std::unique_ptr<FrameRenderer> renderer(const std::shared_ptr<const DeviceVolume>& volume,
                                          std::uint64_t seed = 1);
  std::unique_ptr<Engine> engine_;
};

}  // namespace diaphane::render::cuda
