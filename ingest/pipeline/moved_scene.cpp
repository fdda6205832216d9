#include "ingest/pipeline/moved_scene.h"

#include <google/protobuf/util/json_util.h>

#include <nlohmann/json.hpp>

#include "api/proto/scene.pb.h"

namespace diaphane::ingest {
namespace {

void move(v1::Vec3& place, const volume::Vector& shift) {
  place.set_x(place.x() - shift[0]);
  place.set_y(place.y() - shift[1]);
  place.set_z(place.z() - shift[2]);
}

void move(v1::Light& light, const volume::Vector& shift) {
  if (light.camera_locked()) return;
  switch (light.shape_case()) {
    case v1::Light::kRectangle:
      return move(*light.mutable_rectangle()->mutable_corner(), shift);
    case v1::Light::kDisk:
      return move(*light.mutable_disk()->mutable_centre(), shift);
    case v1::Light::kSphere:
      return move(*light.mutable_sphere()->mutable_centre(), shift);
    case v1::Light::kBox:
      return move(*light.mutable_box()->mutable_corner(), shift);
    case v1::Light::kEnvironment:
    case v1::Light::SHAPE_NOT_SET:
      return;
  }
}

}  // namespace

Result<std::string> moved_scene(const std::string& text, const volume::Vector& shift) {
  v1::Scene scene;
  if (!google::protobuf::util::JsonStringToMessage(text, &scene).ok()) {
    return fail(ErrorCode::kInvalid, "this is not a valid scene");
  }
  if (scene.has_camera()) {
    move(*scene.mutable_camera()->mutable_eye(), shift);
    move(*scene.mutable_camera()->mutable_target(), shift);
  }
  for (v1::Light& light : *scene.mutable_lights()) move(light, shift);
  if (scene.has_clip()) {
    v1::Clip& clip = *scene.mutable_clip();
    if (clip.has_box_low()) move(*clip.mutable_box_low(), shift);
    if (clip.has_box_high()) move(*clip.mutable_box_high(), shift);
    for (auto& plane : *clip.mutable_planes()) move(*plane.mutable_point(), shift);
  }
  if (scene.has_highlight()) move(*scene.mutable_highlight()->mutable_centre(), shift);
  if (scene.has_slices()) {
    v1::Slices& slices = *scene.mutable_slices();
    const auto along = [&](v1::Slices::Slice* slice, std::size_t axis) {
      slice->set_position(slice->position() - shift[axis]);
    };
    if (slices.has_sagittal()) along(slices.mutable_sagittal(), 0);
    if (slices.has_coronal()) along(slices.mutable_coronal(), 1);
    if (slices.has_axial()) along(slices.mutable_axial(), 2);
  }
  std::string moved;
  if (!google::protobuf::util::MessageToJsonString(scene, &moved).ok()) {
    return fail(ErrorCode::kInternal, "cannot serialise the scene");
  }
  return moved;
}

Result<std::string> moved_tour(const std::string& text, const volume::Vector& shift) {
  try {
    auto tour = nlohmann::ordered_json::parse(text);
    for (auto& view : tour.at("views")) {
      for (const char* place : {"eye", "target"}) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          auto& value = view.at(place).at(axis);
          value = value.get<double>() - shift[axis];
        }
      }
    }
    return tour.dump();
  } catch (const nlohmann::json::exception&) {
    return fail(ErrorCode::kInvalid, "this is not a valid tour");
  }
}

}  // namespace diaphane::ingest
