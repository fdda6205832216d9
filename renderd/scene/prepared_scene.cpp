#include "renderd/scene/prepared_scene.h"

#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "renderd/scene/presets.h"

namespace diaphane::render {
namespace {

Double3 vector_of(const diaphane::v1::Vec3& v) { return {v.x(), v.y(), v.z()}; }
Float3 colour_of(const diaphane::v1::Rgb& c) { return to_float(Double3{c.r(), c.g(), c.b()}); }

/// From world space (origin at the box's centre, the patient's axes) to the volume's frame (origin
/// at the corner of voxel (0,0,0), the voxels' axes). Both in mm.
struct WorldToFrame {
  Double3 axes[3];  ///< the voxel axes in the world
  Double3 extent;   ///< of the box

  explicit WorldToFrame(const volume::Header& h) {
    for (std::size_t i = 0; i < 3; ++i) {
      axes[i] = {h.direction[i], h.direction[3 + i], h.direction[6 + i]};
    }
    extent = {h.size[0] * h.spacing[0], h.size[1] * h.spacing[1], h.size[2] * h.spacing[2]};
  }
  Double3 direction(Double3 w) const { return {dot(axes[0], w), dot(axes[1], w), dot(axes[2], w)}; }
  Double3 point(Double3 w) const { return direction(w) + extent * 0.5; }
};

/// Right-handed: x right, y up, z towards the eye; in world space.
struct CameraAxes {
  Double3 right, up, back;

  explicit CameraAxes(const diaphane::v1::Camera& camera) {
    back = normalize(vector_of(camera.eye()) - vector_of(camera.target()));
    right = normalize(cross(normalize(vector_of(camera.up())), back));
    up = cross(back, right);
  }
  Double3 to_world(Double3 v) const { return right * v.x + up * v.y + back * v.z; }
};

CameraView camera_view(const diaphane::v1::Camera& camera, const CameraAxes& axes,
                       const WorldToFrame& frame, Canvas canvas) {
  const Double3 eye = frame.point(vector_of(camera.eye()));
  const Double3 forward = frame.direction(axes.back * -1.0);
  double near = std::numeric_limits<double>::infinity();
  for (int corner = 0; corner < 8; ++corner) {
    const Double3 p{(corner & 1) != 0 ? frame.extent.x : 0.0,
                    (corner & 2) != 0 ? frame.extent.y : 0.0,
                    (corner & 4) != 0 ? frame.extent.z : 0.0};
    near = std::min(near, dot(p - eye, forward));
  }
  near = std::max(near, 0.0);
  const double tangent = std::tan(camera.vertical_fov_degrees() * std::numbers::pi / 360);
  const double aspect = static_cast<double>(canvas.width) / canvas.height;
  CameraView view{};
  view.start = to_float(eye + forward * near);
  view.forward = to_float(forward);
  view.right = to_float(frame.direction(axes.right) * (tangent * aspect));
  view.up = to_float(frame.direction(axes.up) * tangent);
  view.near = static_cast<float>(near);
  return view;
}

double power_of(const AreaLight& light) {
  return static_cast<double>(light.area) * (light.radiance.x + light.radiance.y + light.radiance.z);
}

AreaLight rectangle_of(const diaphane::v1::Light& light, const CameraAxes& axes, Double3 target,
                       const WorldToFrame& frame) {
  const auto& r = light.rectangle();
  Double3 corner = vector_of(r.corner()), u = vector_of(r.u()), v = vector_of(r.v());
  if (light.camera_locked()) {
    corner = target + axes.to_world(corner);
    u = axes.to_world(u);
    v = axes.to_world(v);
  }
  u = frame.direction(u);
  v = frame.direction(v);
  const Double3 normal = cross(u, v);
  AreaLight out{};
  out.corner = to_float(frame.point(corner));
  out.u = to_float(u);
  out.v = to_float(v);
  out.normal = to_float(normalize(normal));
  out.area = static_cast<float>(length(normal));
  out.radiance = colour_of(r.radiance());
  return out;
}

/// Lights without power are left out: they would be picked for nothing.
void prepare_lights(const diaphane::v1::Scene& scene, const CameraAxes& axes,
                    const WorldToFrame& frame, PreparedScene& out) {
  double total = 0;
  for (const auto& light : scene.lights()) {
    if (light.has_environment()) {
      out.environment += colour_of(light.environment().radiance());
    } else {
      const AreaLight r = rectangle_of(light, axes, vector_of(scene.camera().target()), frame);
      if (power_of(r) > 0) {
        out.lights.push_back(r);
        total += power_of(r);
      }
    }
  }
  double sum = 0;
  for (AreaLight& light : out.lights) {
    light.probability = static_cast<float>(power_of(light) / total);
    sum += power_of(light) / total;
    light.cumulative = static_cast<float>(sum);
  }
  if (!out.lights.empty()) out.lights.back().cumulative = 1.0f;
}

Features features_of(const PreparedScene& s) {
  const bool sky = s.environment.x > 0 || s.environment.y > 0 || s.environment.z > 0;
  return Features{}
      .with(Feature::kAreaLights, !s.lights.empty())
      .with(Feature::kManyLights, s.lights.size() > 1)
      .with(Feature::kEnvironment, sky)
      .with(Feature::kAnisotropicPhase, s.phase_g != 0)
      .with(Feature::kSteepExtinction, s.transfer->steep);
}

}  // namespace

Result<PreparedScene> prepare_scene(const diaphane::v1::Scene& scene, Canvas canvas,
                                    const volume::Header& header, const ValueGrid& grid,
                                    const PreparedScene* before,
                                    const diaphane::v1::Scene* before_scene) {
  if (auto checked = check_scene(scene); !checked) return tl::unexpected(checked.error());
  if (canvas.width == 0 || canvas.height == 0 || canvas.width > kLongestCanvas ||
      canvas.height > kLongestCanvas) {
    return fail(ErrorCode::kInvalid, "a picture has 1 to 8192 pixels each way", "canvas");
  }
  const WorldToFrame frame(header);
  const CameraAxes axes(scene.camera());
  PreparedScene out;
  out.canvas = canvas;
  out.spacing = to_float(Double3{header.spacing[0], header.spacing[1], header.spacing[2]});
  out.camera = camera_view(scene.camera(), axes, frame, canvas);
  prepare_lights(scene, axes, frame, out);
  // The nearest fp32 numbers inside (-1, 1): at exactly 1 the phase function has no density.
  constexpr float kMostForward = 0x1.fffffep-1f;
  out.phase_g = std::clamp(static_cast<float>(scene.phase().g()), -kMostForward, kMostForward);
  out.escape = scene.display().show_environment() ? out.environment
                                                  : colour_of(scene.display().background());
  out.exposure_scale = static_cast<float>(std::exp2(scene.display().exposure()));
  using google::protobuf::util::MessageDifferencer;
  if (before != nullptr && before_scene != nullptr &&
      MessageDifferencer::Equals(before_scene->transfer_function(), scene.transfer_function())) {
    out.transfer = before->transfer;
  } else {
    out.transfer = std::make_shared<const PreparedTransfer>(
        prepare_transfer(scene.transfer_function(), grid, size_of(header), out.spacing));
  }
  out.features = features_of(out);
  return out;
}

}  // namespace diaphane::render
