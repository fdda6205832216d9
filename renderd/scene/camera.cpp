#include "renderd/scene/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace diaphane::render {
namespace {

/// Distance before the box at which rays begin, as a fraction of the box's diagonal. Without it
/// rounding would lose parts of the nearest face.
constexpr double kBefore = 1e-3;

/// Returns the distance along the view axis from the eye to just before the box, mm. Nothing behind
/// the eye is visible.
double start_depth(Double3 eye, Double3 forward, const WorldToFrame& frame) {
  double near = std::numeric_limits<double>::infinity();
  for (unsigned i = 0; i < 8; ++i) near = std::min(near, dot(frame.corner(i) - eye, forward));
  return std::max(near - kBefore * length(frame.extent), 0.0);
}

}  // namespace

CameraAxes::CameraAxes(const diaphane::v1::Camera& camera) {
  back = normalize(vector_of(camera.eye()) - vector_of(camera.target()));
  right = normalize(cross(normalize(vector_of(camera.up())), back));
  up = cross(back, right);
}

CameraView prepare_camera(const diaphane::v1::Camera& camera, const CameraAxes& axes,
                          const WorldToFrame& frame, Canvas canvas) {
  const Double3 eye = frame.point(vector_of(camera.eye()));
  const Double3 forward = frame.direction(axes.back * -1.0);
  const Double3 right = frame.direction(axes.right), up = frame.direction(axes.up);
  const double depth = start_depth(eye, forward, frame);
  const bool parallel = camera.orthographic_height() > 0;
  const double half_height = parallel
                                 ? camera.orthographic_height() / 2
                                 : std::tan(camera.vertical_fov_degrees() * std::numbers::pi / 360);
  const double aspect = static_cast<double>(canvas.width) / canvas.picture_height();
  CameraView view{};
  view.start = to_float(eye + forward * depth);
  view.forward = to_float(forward);
  view.right = to_float(right * (half_height * aspect));
  view.up = to_float(up * half_height);
  view.near = parallel ? 1.0f : static_cast<float>(depth);
  view.spread = parallel ? 0.0f : 1.0f;
  const double focus = camera.focal_distance() > 0
                           ? camera.focal_distance()
                           : length(vector_of(camera.target()) - vector_of(camera.eye()));
  view.lens_right = to_float(right * camera.aperture_radius());
  view.lens_up = to_float(up * camera.aperture_radius());
  view.lens_at_start = static_cast<float>((focus - depth) / focus);
  view.lens_bend = static_cast<float>(1 / focus);
  return view;
}

}  // namespace diaphane::render
