#pragma once

#include "api/proto/scene.pb.h"
#include "renderd/kernel/views.h"
#include "renderd/scene/frame.h"
#include "volume/volume.h"

namespace diaphane::render {

/// All functions of this file require parts of a scene that has passed check_scene().
ClipView prepare_clip(const diaphane::v1::Clip& clip, const WorldToFrame& frame, Double3 spacing);

/// Assigns to each axis of the patient the nearest voxel axis (0 to 2), a different one for each,
/// and the sign of its direction along that axis.
struct PatientAxes {
  int voxel_axis[3];
  double sign[3];
};
PatientAxes patient_axes(const volume::Header& header);

/// Returns the tone curve of the display.
ToneCurve curve_of(const diaphane::v1::Display& display);

/// Returns the shown slices of a scene. Omits those outside the volume.
SlicesView prepare_slices(const diaphane::v1::Scene& scene, const volume::Header& header);
bool any_slice(const SlicesView& slices);

}  // namespace diaphane::render
