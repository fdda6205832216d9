#pragma once

#include "api/proto/scene.pb.h"
#include "renderd/kernel/views.h"
#include "renderd/scene/frame.h"
#include "volume/volume.h"

namespace diaphane::render {

/// All have passed check_scene.
ClipView prepare_clip(const diaphane::v1::Clip& clip, const WorldToFrame& frame, Double3 spacing);

/// The voxel axis (0 to 2) nearest to each of the patient's axes, one each, and on which side of it
/// the patient's axis points.
struct PatientAxes {
  int voxel_axis[3];
  double sign[3];
};
PatientAxes patient_axes(const volume::Header& header);

/// Slices outside the volume are left out.
SlicesView prepare_slices(const diaphane::v1::Scene& scene, const volume::Header& header);
bool any_slice(const SlicesView& slices);

}  // namespace diaphane::render
