#include "tests/support/renderd/test_device.h"

#include <cmath>

#include "common/try.h"
#include "renderd/engine/cuda/engine.h"

namespace diaphane::render::cuda {
namespace {

void set(diaphane::v1::Vec3* to, double x, double y, double z) {
  to->set_x(x);
  to->set_y(y);
  to->set_z(z);
}
void set(diaphane::v1::Rgb* to, double r, double g, double b) {
  to->set_r(r);
  to->set_g(g);
  to->set_b(b);
}

void add_channel(diaphane::v1::Scene& scene,
                 std::initializer_list<std::pair<double, double>> points, double r, double g,
                 double b) {
  auto* channel = scene.mutable_transfer_function()->add_channels();
  for (const auto& [value, opacity] : points) {
    auto* point = channel->add_opacity();
    point->set_value(value);
    point->set_opacity(opacity);
  }
  set(channel->mutable_diffuse(), r, g, b);
}

void add_rectangle(diaphane::v1::Scene& scene, double x, double y, double z, double side,
                   double radiance) {
  auto* light = scene.add_lights()->mutable_rectangle();
  set(light->mutable_corner(), x - side / 2, y - side / 2, z);
  // cross(u, v) points to -z, so a light above the volume shines down on it.
  set(light->mutable_u(), 0, side, 0);
  set(light->mutable_v(), side, 0, 0);
  set(light->mutable_radiance(), radiance, 0.8 * radiance, 0.5 * radiance);
}

/// Returns the quantile of the upper tail of the normal distribution, by bisection on erfc.
double normal_quantile(double upper_tail) {
  double low = 0, high = 40;
  for (int i = 0; i < 200; ++i) {
    const double middle = (low + high) / 2;
    (0.5 * std::erfc(middle / std::sqrt(2.0)) > upper_tail ? low : high) = middle;
  }
  return low;
}

}  // namespace

volume::Volume lumpy_volume(std::uint32_t nx, std::uint32_t ny, std::uint32_t nz) {
  volume::Volume volume;
  volume.header.size = {nx, ny, nz};
  volume.header.spacing = {1, 1.5, 2};
  volume.header.direction = {0, 0, 1, 1, 0, 0, 0, 1, 0};
  volume.voxels.reserve(volume.header.voxel_count());
  for (std::uint32_t z = 0; z < nz; ++z) {
    for (std::uint32_t y = 0; y < ny; ++y) {
      for (std::uint32_t x = 0; x < nx; ++x) {
        const double wave =
            std::sin(0.55 * x + 0.2 * z) * std::sin(0.4 * y + 0.5) * std::cos(0.3 * z - 0.15 * x);
        volume.voxels.push_back(static_cast<std::int16_t>(std::lround(500 + 500 * wave)));
      }
    }
  }
  volume::measure(volume);
  return volume;
}

volume::Volume constant_volume(std::uint32_t n, std::int16_t value) {
  volume::Volume volume;
  volume.header.size = {n, n, n};
  volume.voxels.assign(volume.header.voxel_count(), value);
  volume::measure(volume);
  return volume;
}

diaphane::v1::Scene full_scene() {
  diaphane::v1::Scene scene;
  add_channel(scene, {{450, 0}, {600, 0.3}, {800, 0.1}}, 0.9, 0.5, 0.4);
  add_channel(scene, {{700, 0}, {750, 1}, {1000, 0.6}}, 0.8, 0.85, 0.9);
  scene.mutable_transfer_function()->set_extinction_per_mm(0.5);
  add_rectangle(scene, 10, -20, 120, 40, 60);
  add_rectangle(scene, -40, 30, 90, 15, 200);
  set(scene.add_lights()->mutable_environment()->mutable_radiance(), 0.3, 0.4, 0.5);
  set(scene.mutable_camera()->mutable_eye(), 90, 70, 60);
  set(scene.mutable_camera()->mutable_target(), 0, 0, 0);
  set(scene.mutable_camera()->mutable_up(), 0, 0, 1);
  scene.mutable_camera()->set_vertical_fov_degrees(35);
  scene.mutable_phase()->set_g(0.4);
  set(scene.mutable_display()->mutable_background(), 0.1, 0.1, 0.1);
  return scene;
}

diaphane::v1::Scene transmittance_scene(double extinction_per_mm) {
  diaphane::v1::Scene scene;
  add_channel(scene, {{-32768, 1}, {32767, 1}}, 0, 0, 0);
  scene.mutable_transfer_function()->set_extinction_per_mm(extinction_per_mm);
  set(scene.mutable_camera()->mutable_eye(), 0, 0, 5000);
  set(scene.mutable_camera()->mutable_target(), 0, 0, 0);
  set(scene.mutable_camera()->mutable_up(), 0, 1, 0);
  scene.mutable_camera()->set_vertical_fov_degrees(0.05);
  set(scene.mutable_display()->mutable_background(), 1, 1, 1);
  return scene;
}

double critical_t(double p, double dof) {
  const double z = normal_quantile(p / 2);
  const double z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
  return z + (z3 + z) / (4 * dof) + (5 * z5 + 16 * z3 + 3 * z) / (96 * dof * dof) +
         (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * dof * dof * dof);
}

double sidak(double alpha, std::size_t tests) {
  return -std::expm1(std::log1p(-alpha) / static_cast<double>(tests));
}

Result<void> render_all(FrameRenderer& renderer, const diaphane::v1::Scene& scene, Canvas canvas,
                        std::uint32_t samples) {
  if (auto set = renderer.set_scene(scene, canvas); !set) return set;
  auto batch = renderer.render(samples, [] { return false; });
  DIAPHANE_TRY(batch);
  if (batch->samples != samples) return fail(ErrorCode::kInternal, "stopped by itself");
  return {};
}

std::vector<float> radiance_of(FrameRenderer& renderer) {
  PictureRgbF picture;
  const auto done = renderer.radiance(picture);
  EXPECT_TRUE(done) << done.error().message;
  return picture.pixels;
}

void CudaTest::SetUp() {
  auto engine = make_cuda_engine();
  if (!engine) {
    ASSERT_EQ(engine.error().code, ErrorCode::kUnavailable) << engine.error().message;
    GTEST_SKIP() << engine.error().message;
  }
  engine_ = std::move(*engine);
}

std::unique_ptr<FrameRenderer> CudaTest::renderer(const std::shared_ptr<const DeviceVolume>& volume,
                                                  std::uint64_t seed) {
  auto made = engine_->renderer(volume, seed, 0);
  EXPECT_TRUE(made) << made.error().message;
  return made ? std::move(*made) : nullptr;
}

}  // namespace diaphane::render::cuda
