#include "renderd/session/depth.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "renderd/kernel/medium.h"
#include "renderd/kernel/primary.h"
#include "renderd/scene/camera.h"
#include "renderd/scene/frame.h"
#include "renderd/scene/prepared_scene.h"

namespace diaphane::render {
namespace {

constexpr double kMostVoxels = 1'000'000;
/// Opacity of a ray below which it shows only background.
constexpr float kLeastSeen = 0.02f;
/// Transmittance at which a ray counts as opaque.
constexpr float kEnd = 0.01f;

using View = SceneView<LinearVolume>;

/// Returns a distance in mm along the ray.
std::optional<float> half_way(const View& scene, const Ray& ray) {
  Span span = clip(ray, scene.grid.occupied, Span{0.0f, 3.4e38f});
  span = clip_span<kAllFeatures>(scene, ray, span, RayKind::kCamera);
  const SliceHit slice = nearest_slice<kAllFeatures>(scene, ray);
  if (slice.found) span.end = min(span.end, slice.distance);
  struct Step {
    float at, clear;  // transmittance from the eye to this place
  };
  std::vector<Step> steps;
  float clear = 1.0f;
  if (span.begin < span.end) {
    const Float3 d = ray.direction;
    const float per_mm = max(max(std::fabs(d.x), std::fabs(d.y)), std::fabs(d.z));
    const float count = std::ceil(2.0f * (span.end - span.begin) * per_mm) + 1.0f;
    const float step = (span.end - span.begin) / count;
    for (float i = 0.5f; i < count && clear > kEnd; i += 1.0f) {
      const float at = span.begin + i * step;
      clear *= std::exp(-extinction_at(scene.transfer, scene.volume.at(ray.at(at))) * step);
      steps.push_back({at, clear});
    }
  }
  const float behind = slice.found ? 0.0f : clear;
  if (1.0f - behind < kLeastSeen) return std::nullopt;
  const float half = (1.0f + behind) / 2;
  const auto there =
      std::ranges::find_if(steps, [half](const Step& one) { return one.clear <= half; });
  return there == steps.end() ? slice.distance : there->at;
}

}  // namespace

std::shared_ptr<const CoarseVolume> coarse_of(const volume::Volume& volume) {
  auto coarse = std::make_shared<CoarseVolume>();
  const volume::Header& from = volume.header;
  volume::Header& to = coarse->volume.header;
  to = from;
  const double by = std::max(1.0, std::cbrt(static_cast<double>(from.voxel_count()) / kMostVoxels));
  std::array<std::vector<std::size_t>, 3> nearest;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double size = from.size[axis];
    to.size[axis] = static_cast<std::uint32_t>(std::max(1.0, std::floor(size / by)));
    to.spacing[axis] = from.spacing[axis] * size / to.size[axis];
    for (std::uint32_t i = 0; i < to.size[axis]; ++i) {
      nearest[axis].push_back(static_cast<std::size_t>((i + 0.5) * size / to.size[axis]));
    }
  }
  coarse->volume.voxels.reserve(to.voxel_count());
  for (const std::size_t z : nearest[2]) {
    for (const std::size_t y : nearest[1]) {
      const std::size_t row = from.size[0] * (y + std::size_t{from.size[1]} * z);
      for (const std::size_t x : nearest[0]) {
        coarse->volume.voxels.push_back(volume.voxels[row + x]);
      }
    }
  }
  coarse->grid = make_value_grid(coarse->volume.voxels, size_of(to));
  return coarse;
}

std::optional<VisiblePoint> visible_point_at(const CoarseVolume& coarse,
                                             const diaphane::v1::Scene& scene, Canvas canvas,
                                             double x, double y) {
  diaphane::v1::Scene dark = scene;  // lights do not matter here, and their textures take time
  dark.clear_lights();
  dark.mutable_camera()->set_aperture_radius(0);
  const volume::Header& header = coarse.volume.header;
  const auto prepared = prepare_scene(dark, canvas, header, coarse.grid);
  if (!prepared) return std::nullopt;
  const PreparedTransfer& t = *prepared->transfer;
  const View view =
      view_of(*prepared, LinearVolume{coarse.volume.voxels.data(), size_of(header)},
              t.extinction.data(), t.colour.data(), t.bounds.data(), LightArrays(*prepared), 0);
  const Ray ray = camera_ray<kAllFeatures>(view, static_cast<float>(x * canvas.width),
                                           static_cast<float>(y * canvas.height))
                      .ray;
  const std::optional<float> at = half_way(view, ray);
  if (!at) return std::nullopt;
  const WorldToFrame frame(header);
  const Float3 index = ray.at(*at);
  const Double3 in_frame{index.x * header.spacing[0], index.y * header.spacing[1],
                         index.z * header.spacing[2]};
  const Double3 from_middle = in_frame - frame.extent * 0.5;
  VisiblePoint visible;
  visible.place =
      frame.axes[0] * from_middle.x + frame.axes[1] * from_middle.y + frame.axes[2] * from_middle.z;
  visible.distance =
      dot(visible.place - vector_of(scene.camera().eye()), CameraAxes(scene.camera()).back * -1.0);
  return visible;
}

}  // namespace diaphane::render
