#pragma once

#include "api/proto/scene.pb.h"
#include "renderd/film/canvas.h"
#include "renderd/kernel/views.h"
#include "renderd/scene/frame.h"

namespace diaphane::render {

/// Axes of the camera's frame in world space: right-handed, x right, y up, z towards the eye.
struct CameraAxes {
  Double3 right, up, back;

  explicit CameraAxes(const diaphane::v1::Camera& camera);
  Double3 to_world(Double3 v) const { return right * v.x + up * v.y + back * v.z; }
};

/// Prepares a camera that has passed check_scene() for a canvas.
CameraView prepare_camera(const diaphane::v1::Camera& camera, const CameraAxes& axes,
                          const WorldToFrame& frame, Canvas canvas);

}  // namespace diaphane::render
