#include "renderd/session/depth.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "renderd/kernel/overlay.h"
#include "renderd/kernel/primary.h"
#include "renderd/scene/camera.h"
#include "renderd/scene/frame.h"
#include "renderd/session/coarse_view.h"

namespace diaphane::render {
namespace {

constexpr double kMostVoxels = 1'000'000;
/// Opacity of a ray below which it shows only background.
constexpr float kLeastSeen = 0.02f;
/// Transmittance at which a ray counts as opaque.
constexpr float kEnd = 0.01f;
/// The surface on which a place was pressed may be this many coarse voxels thick when it is seen
/// from another side.
constexpr double kOwnSurfaceVoxels = 2;

using View = CoarseView;

struct Step {
  float at, clear;  // transmittance from the eye to this place
};

/// What a ray meets: the nearest slice, and the transmittance before it.
struct Walk {
  SliceHit slice;
  std::vector<Step> steps;
  float clear = 1.0f;  // at the last step
};

/// Follows the ray of a column of the picture for `most` mm or until it is opaque.
Walk walk(const View& scene, const Ray& ray, float column, float most) {
  Walk walked;
  Span span = clip(ray, scene.grid.occupied, Span{0.0f, most});
  span = clip_span<kAllFeatures>(scene, ray, span, RayKind::kCamera);
  walked.slice = nearest_slice<kAllFeatures>(scene, ray);
  if (walked.slice.found) span.end = min(span.end, walked.slice.distance);
  if (span.begin >= span.end) return walked;
  const Float3 d = ray.direction;
  const float per_mm = max(max(std::fabs(d.x), std::fabs(d.y)), std::fabs(d.z));
  const float count = std::ceil(2.0f * (span.end - span.begin) * per_mm) + 1.0f;
  const float step = (span.end - span.begin) / count;
  float& clear = walked.clear;
  const auto medium = medium_of<kAllFeatures>(scene, shares_at<kAllFeatures>(scene, column));
  for (float i = 0.5f; i < count && clear > kEnd; i += 1.0f) {
    const float at = span.begin + i * step;
    const Float3 place = ray.at(at);
    clear *= std::exp(-medium.extinction(scene.volume.at(place), place) * step);
    walked.steps.push_back({at, clear});
  }
  return walked;
}

/// Returns the distance in mm along the ray at which half of what it shows has been passed.
std::optional<float> half_way(const View& scene, const Ray& ray, float column) {
  const auto [slice, steps, clear] = walk(scene, ray, column, 3.4e38f);
  const float behind = slice.found ? 0.0f : clear;
  if (1.0f - behind < kLeastSeen) return std::nullopt;
  const float half = (1.0f + behind) / 2;
  const auto there =
      std::ranges::find_if(steps, [half](const Step& one) { return one.clear <= half; });
  return there == steps.end() ? slice.distance : there->at;
}

/// Returns whether less than half of a place in the volume's frame (mm) can be seen. `margin`:
/// distance in mm in front of the place in which matter counts as its own surface.
bool is_hidden(const View& scene, Float3 place, float margin) {
  const CameraView& c = scene.camera;
  const Float3 from_start = place - c.start;
  const float depth = dot(from_start, c.forward);
  const float factor = c.near + depth * c.spread;
  if (depth <= 0 || factor <= 0) return false;  // nothing lies before the box
  const Float3 aside = (from_start - c.forward * depth) * (1 / factor);
  const Float3 start = c.start + aside * c.near;
  const Float3 along = normalize(c.forward + aside * c.spread);
  const Ray ray{start * scene.inverse_spacing, along * scene.inverse_spacing};
  const float most = dot(place - start, along) - margin;
  if (most <= 0) return false;
  const float right = dot(aside, c.right) / dot(c.right, c.right);  // -1 to 1 in the picture
  const float column = 0.5f * (right + 1.0f) * static_cast<float>(scene.width);
  const Walk walked = walk(scene, ray, column, most);
  return walked.clear < 0.5f || (walked.slice.found && walked.slice.distance < most);
}

/// Returns the number of the label at a place (voxel indices), or 0.
std::uint32_t label_at(const volume::Volume& volume, Float3 place) {
  const volume::LabelSet& set = volume.label_set;
  if (set.empty()) return 0;
  const auto along = [&](float at, std::size_t axis) {
    const std::uint32_t size = volume.header.size[axis];
    return std::min(static_cast<std::size_t>(std::max(at, 0.0F)), std::size_t{size - 1});
  };
  const std::size_t x = along(place.x, 0), y = along(place.y, 1), z = along(place.z, 2);
  const auto& size = volume.header.size;
  const std::uint8_t value = set.labels.voxels[x + size[0] * (y + std::size_t{size[1]} * z)];
  return value == 0 ? 0 : set.table[value - 1U].number;
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
  for (std::size_t axis = 0; to.origin && axis < 3; ++axis) {
    const double shift = (to.spacing[axis] - from.spacing[axis]) / 2;
    for (std::size_t row = 0; row < 3; ++row) {
      (*to.origin)[row] += shift * from.direction[3 * row + axis];
    }
  }
  coarse->volume.voxels.reserve(to.voxel_count());
  const volume::Labels& labels = volume.label_set.labels;
  volume::LabelSet& coarse_set = coarse->volume.label_set;
  coarse_set = {volume.label_set.table, {to.size, {}}};
  if (!coarse_set.empty()) coarse_set.labels.voxels.reserve(to.voxel_count());
  for (const std::size_t z : nearest[2]) {
    for (const std::size_t y : nearest[1]) {
      const std::size_t row = from.size[0] * (y + std::size_t{from.size[1]} * z);
      for (const std::size_t x : nearest[0]) {
        coarse->volume.voxels.push_back(volume.voxels[row + x]);
        if (!coarse_set.empty()) coarse_set.labels.voxels.push_back(labels.voxels[row + x]);
      }
    }
  }
  coarse->grid = make_value_grid(coarse->volume.voxels, size_of(to));
  coarse->grid.labels = make_label_grid(coarse_set, size_of(to));
  return coarse;
}

std::optional<VisiblePoint> visible_point_at(const CoarseVolume& coarse,
                                             const diaphane::v1::Scene& scene, Canvas canvas,
                                             double x, double y, const CoarseSecond& second) {
  std::optional<VisiblePoint> visible;
  with_coarse_view(coarse, second, scene, canvas, [&](const View& view) {
    const auto column = static_cast<float>(x * canvas.width);
    const Ray ray =
        camera_ray<kAllFeatures>(view, column, static_cast<float>(y * canvas.height)).ray;
    const std::optional<float> at = half_way(view, ray, column);
    if (!at) return;
    const volume::Header& header = coarse.volume.header;
    const WorldToFrame frame(header);
    const Float3 index = ray.at(*at);
    const Double3 in_frame{index.x * header.spacing[0], index.y * header.spacing[1],
                           index.z * header.spacing[2]};
    const Double3 from_middle = in_frame - frame.extent * 0.5;
    visible.emplace();
    visible->place = frame.axes[0] * from_middle.x + frame.axes[1] * from_middle.y +
                     frame.axes[2] * from_middle.z;
    visible->label = label_at(coarse.volume, index);
    visible->distance = dot(visible->place - vector_of(scene.camera().eye()),
                            CameraAxes(scene.camera()).back * -1.0);
  });
  return visible;
}

std::vector<bool> hidden_places(const CoarseVolume& coarse, const diaphane::v1::Scene& scene,
                                Canvas canvas, const std::vector<Double3>& places,
                                const CoarseSecond& second) {
  std::vector<bool> hidden(places.size());
  const volume::Header& header = coarse.volume.header;
  const WorldToFrame frame(header);
  const double voxel = std::max({header.spacing[0], header.spacing[1], header.spacing[2]});
  with_coarse_view(coarse, second, scene, canvas, [&](const View& view) {
    for (std::size_t i = 0; i < places.size(); ++i) {
      hidden[i] = is_hidden(view, to_float(frame.point(places[i])),
                            static_cast<float>(kOwnSurfaceVoxels * voxel));
    }
  });
  return hidden;
}

}  // namespace diaphane::render
