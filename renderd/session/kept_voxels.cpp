#include "renderd/session/kept_voxels.h"

namespace diaphane::render {
namespace {

volume::Vector vector(const v1::Vec3& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

volume::KeptVoxels kept_by(const volume::Header& header, const v1::Clip& clip) {
  std::vector<volume::Region::Plane> planes;
  if (clip.has_box_low() && clip.has_box_high()) {
    planes = volume::faces_of(vector(clip.box_low()), vector(clip.box_high()));
  }
  for (const v1::Clip::Plane& plane : clip.planes()) {
    planes.push_back({vector(plane.point()), vector(plane.normal())});
  }
  return {header, planes};
}

}  // namespace diaphane::render
