#include "renderd/scene/prepared_scene.h"

#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "common/try.h"
#include "renderd/kernel/direct.h"
#include "renderd/scene/camera.h"
#include "renderd/scene/clip_slices.h"
#include "renderd/scene/frame.h"
#include "renderd/scene/lights.h"
#include "renderd/scene/presets.h"

namespace diaphane::render {
namespace {

/// Adds what the matter of the second scan needs.
Features with_overlay(Features features, const PreparedScene& s) {
  if (!s.overlay) return features;
  const PreparedTransfer& t = *s.overlay->transfer;
  const bool surfaces = features.has(Feature::kSurfaces);
  return features.with(Feature::kOverlay)
      .with(Feature::kCurves)
      .with(Feature::kGloss, features.has(Feature::kGloss) || (surfaces && !t.gloss.empty()))
      .with(Feature::kEmission, features.has(Feature::kEmission) || !t.emission.empty());
}

/// Returns the transfer function: that of the previous scene if it is the same.
std::shared_ptr<const PreparedTransfer> transfer_of(const diaphane::v1::Scene& scene,
                                                    const ValueGrid& grid, Int3 size,
                                                    Float3 spacing, const PreparedScene* before,
                                                    const diaphane::v1::Scene* before_scene,
                                                    TransferCache* baked) {
  using google::protobuf::util::MessageDifferencer;
  const auto& function = scene.transfer_function();
  if (before != nullptr && before_scene != nullptr &&
      MessageDifferencer::Equals(before_scene->transfer_function(), function)) {
    return before->transfer;
  }
  if (baked != nullptr) return baked->get(function, grid, size, spacing);
  return std::make_shared<const PreparedTransfer>(prepare_transfer(function, grid, size, spacing));
}

/// Returns whether the overlay of the previous scene is also that of this one, apart from the
/// second scan itself. A change of the camera does not change it.
bool keeps_overlay(const PreparedScene& s, const diaphane::v1::Scene& scene,
                   const PreparedScene* before, const diaphane::v1::Scene* before_scene) {
  using google::protobuf::util::MessageDifferencer;
  return before != nullptr && before_scene != nullptr && before->transfer == s.transfer &&
         before->labels == s.labels && before->canvas.width == s.canvas.width &&
         MessageDifferencer::Equals(before_scene->overlay(), scene.overlay()) &&
         MessageDifferencer::Equals(before_scene->shading(), scene.shading());
}

Features features_of(const diaphane::v1::Scene& scene, const PreparedScene& s, Features lights) {
  const Features visible =
      Features{}
          .with(Feature::kLens, scene.camera().aperture_radius() > 0)
          .with(Feature::kOrthographic, scene.camera().orthographic_height() > 0)
          .with(Feature::kClip, s.clip.count > 0)
          .with(Feature::kSlices, any_slice(s.slices));
  if (!s.matter) {
    return visible.with(Feature::kTexturedEnvironment, s.maps_visible)
        .with(Feature::kOverlay, s.overlay != nullptr);
  }
  const Features features =
      Features{visible.bits | lights.bits}
          .with(Feature::kAnisotropicPhase, s.phase_g != 0)
          .with(Feature::kCurves, s.transfer->exact.pieces.size() != 1)
          .with(Feature::kSurfaces, s.surfaces > 0)
          .with(Feature::kHybrid, s.surfaces > 0 && std::isfinite(s.surfaces))
          .with(Feature::kGloss, s.surfaces > 0 && !s.transfer->gloss.empty())
          .with(Feature::kEmission, !s.transfer->emission.empty())
          .with(Feature::kBounces, s.bounces > 1)
          .with(Feature::kSteepExtinction, s.overlay  ? s.overlay->steep
                                           : s.labels ? s.labels->steep
                                                      : s.transfer->steep)
          .with(Feature::kLabels, s.labels != nullptr || s.highlight.strength > 0)
          .with(Feature::kClipLight, s.clip.light_count > 0);
  return with_overlay(features, s);
}

HighlightView prepare_highlight(const diaphane::v1::Scene& scene, const WorldToFrame& frame) {
  if (!scene.has_highlight()) return {};
  constexpr double kUsualStrength = 0.75;
  const auto& highlight = scene.highlight();
  const double strength = highlight.strength() > 0 ? highlight.strength() : kUsualStrength;
  return {.centre = to_float(frame.point(vector_of(highlight.centre()))),
          .squared_radius = static_cast<float>(highlight.radius() * highlight.radius()),
          .colour = colour_of(highlight.colour()),
          .strength = static_cast<float>(strength)};
}

/// Sets what a camera ray that leaves the volume shows.
void prepare_background(const diaphane::v1::Display& display, PreparedScene& out) {
  out.escape = display.show_environment() ? out.environment : colour_of(display.background());
  if (!display.show_environment() && display.has_background_edge()) {
    out.escape_edge = colour_of(display.background_edge()) - out.escape;
  }
}

/// Returns the share of the sky in the light that reaches the middle of the volume if nothing is in
/// the way, in [0, 1].
double share_of_sky(const PreparedScene& scene) {
  // Computed in double, because the radiances may be as large as a float can be.
  const auto brightness = [](Float3 c) { return double{c.x} + c.y + c.z; };
  double lamps = 0;
  for (const AreaLight& light : scene.lights) {
    const bool flat = light.shape == LightShape::kRectangle;
    const Float3 centre = flat ? light.corner + (light.u + light.v) * 0.5f : light.corner;
    const Float3 to = centre - scene.middle;
    const double squared = std::max(dot(to, to), light.area);
    const double facing =
        light.shape == LightShape::kSphere ? 1 : -dot(light.normal, to) / std::sqrt(squared);
    lamps += brightness(light.radiance) * light.area * std::max(facing, 0.0) / squared;
  }
  const double sky = 4 * std::numbers::pi * brightness(scene.environment);
  return sky > 0 ? sky / (sky + lamps) : 0;
}

}  // namespace

std::array<std::int32_t, kHitKinds> strata_for(const PreparedScene& scene) {
  // These numbers gave the least error in a given time on the cranium scene. The light of the sky
  // varies more with the direction than the light of a lamp varies with the point on it.
  const auto kind = [](Strategy strategy) { return static_cast<std::size_t>(strategy); };
  const Float3 e = scene.environment;
  const bool sky = e.x > 0 || e.y > 0 || e.z > 0, maps = !scene.maps.empty(),
             lamps = !scene.lights.empty();
  // If rays end within a voxel, the light at the few collisions of a pixel varies most, and most
  // rays to the lights are short. One pass with more of them then reaches an error sooner than two
  // passes.
  constexpr float kOpaque = 3;
  const Float3 edges = scene.spacing;
  const bool opaque = scene.transfer->densest * std::min({edges.x, edges.y, edges.z}) > kOpaque;
  const std::int32_t lamp = opaque ? 6 : 4, open = opaque ? 13 : 9;
  std::array<std::int32_t, kHitKinds> strata{};
  const bool surfaces = scene.features.has(Feature::kSurfaces) && lamps && !maps;
  if (surfaces) {
    // Measured on the built-in looks and five scenes: few directions of the scattering meet a lamp,
    // and each kind of light needs samples in proportion to what it contributes.
    constexpr std::int32_t kDirect = 13, kSkyLow = 2, kSkyHigh = 9;
    const auto wanted = static_cast<std::int32_t>(std::lround(14 * share_of_sky(scene)));
    const std::int32_t of_sky = sky ? std::clamp(wanted, kSkyLow, kSkyHigh) : 0;
    strata[kind(Strategy::kEnvironment)] = of_sky;
    strata[kind(Strategy::kAreaLight)] = kDirect - of_sky;
    strata[kind(Strategy::kAreaLightByScatter)] = 1;
  } else {
    if (lamps) strata[kind(Strategy::kAreaLight)] = lamp;
    if (lamps && mixes(scene)) strata[kind(Strategy::kAreaLightByScatter)] = 3;
    if (maps) strata[kind(Strategy::kEnvironmentMap)] = 8;
    if (sky || (maps && mixes(scene))) strata[kind(Strategy::kEnvironment)] = maps ? 5 : open;
  }
  std::int32_t sum = 0;
  for (std::int32_t n : strata) sum += n;
  // If there is only one kind of light, it gets the samples of both. Glowing matter needs
  // collisions even without lights.
  if (lamps && sum == lamp) strata[kind(Strategy::kAreaLight)] = lamp + open - 1;
  if (sum == 0) strata[kind(Strategy::kEnvironment)] = 8;
  // Paths of very many collisions cost more than everything else together. One such path has the
  // least error in a given time and keeps a launch short.
  constexpr std::uint32_t kLongPaths = 128;
  if (scene.features.has(Feature::kBounces)) {
    strata[kIndirect] = scene.bounces > kLongPaths ? 1 : surfaces ? 6 : 4;
  }
  return strata;
}

bool use_exact_walk(const PreparedScene& scene, Method method) {
  return method.walk != Walk::kTracking && !scene.transfer->exact.pieces.empty() &&
         scene.labels == nullptr && scene.overlay == nullptr;
}

Result<PreparedScene> prepare_scene(const diaphane::v1::Scene& scene, Canvas canvas,
                                    const volume::Header& header, const ValueGrid& grid,
                                    const PreparedScene* before,
                                    const diaphane::v1::Scene* before_scene, TransferCache* baked,
                                    const SecondScan* second) {
  DIAPHANE_TRY(check_scene(scene));
  if (!is_sound(canvas)) {
    return fail(
        ErrorCode::kInvalid,
        "a picture must have 1 to 16384 pixels in each direction, and at most 2^26 in total",
        "canvas");
  }
  const WorldToFrame frame(header);
  const CameraAxes axes(scene.camera());
  PreparedScene out;
  out.canvas = canvas;
  out.spacing = to_float(Double3{header.spacing[0], header.spacing[1], header.spacing[2]});
  const Int3 size = size_of(header);
  out.middle =
      out.spacing * Float3{0.5f * static_cast<float>(size.x), 0.5f * static_cast<float>(size.y),
                           0.5f * static_cast<float>(size.z)};
  out.camera = prepare_camera(scene.camera(), axes, frame, canvas);
  out.clip = prepare_clip(scene.clip(), frame, to_double(out.spacing));
  out.slices = prepare_slices(scene, header);
  out.highlight = prepare_highlight(scene, frame);
  out.matter = !scene.slices().alone();
  auto lights = prepare_lights(scene, axes, frame, before != nullptr ? before->textures : nullptr);
  DIAPHANE_TRY(lights);
  const Features light_features = features_of(*lights);
  out.lights = std::move(lights->area);
  out.environment = lights->environment;
  out.maps = std::move(lights->maps);
  out.textures = std::move(lights->textures);
  out.maps_visible = scene.display().show_environment() && !out.maps.empty();
  // The fp32 number below 1. At exactly 1 or -1 the phase function has no density.
  constexpr float kMostForward = 0x1.fffffep-1f;
  out.phase_g = std::clamp(static_cast<float>(scene.phase().g()), -kMostForward, kMostForward);
  out.surfaces = surfaces_of(scene.shading(), scene.transfer_function().extinction_per_mm());
  out.bounces = std::max(scene.bounces(), 1u);
  prepare_background(scene.display(), out);
  out.exposure = scene.display().exposure();
  out.automatic_exposure = scene.display().automatic_exposure() && !any_slice(out.slices);
  out.curve = curve_of(scene.display());
  out.transfer = transfer_of(scene, grid, size, out.spacing, before, before_scene, baked);
  const bool keeps_labels = before_scene != nullptr && before != nullptr &&
                            before->transfer == out.transfer &&
                            have_same_labels(*before_scene, scene);
  out.labels = keeps_labels ? before->labels
                            : prepare_labels(scene, *out.transfer, grid.labels, size, out.spacing);
  if (second != nullptr && keeps_overlay(out, scene, before, before_scene) && second->as_before) {
    out.overlay = before->overlay;
  } else if (second != nullptr) {
    out.overlay =
        prepare_overlay(scene, *out.transfer, first_bounds_of(out), header, canvas.width, *second);
  }
  out.features = features_of(scene, out, light_features);
  return out;
}

}  // namespace diaphane::render
