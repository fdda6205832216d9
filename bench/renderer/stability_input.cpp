// NaN and infinity in every number of a scene must be refused with the field's name, and the
// picture must stay.
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <cmath>
#include <limits>
#include <set>

#include "bench/renderer/stability_case.h"

namespace diaphane::render::bench {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

constexpr Canvas kCanvas{16, 16};

/// Returns a scene that uses every feature but light.
diaphane::v1::Scene full_scene() {
  diaphane::v1::Scene scene = test::skull_scene();
  auto* channel = scene.mutable_transfer_function()->mutable_channels(0);
  test::set(channel->mutable_specular(), 0.1, 0.1, 0.1);
  channel->set_gloss(0.5);
  test::set(channel->mutable_emission(), 0.1, 0.1, 0.1);
  auto& camera = *scene.mutable_camera();
  camera.set_orthographic_height(60);
  camera.set_aperture_radius(1);
  camera.set_focal_distance(80);
  scene.mutable_phase()->set_g(0.2);
  scene.mutable_shading()->set_mode(diaphane::v1::Shading::HYBRID);
  scene.mutable_shading()->set_gradient_scale(0.2);
  test::set(scene.mutable_clip()->mutable_box_low(), -20, -20, -20);
  test::set(scene.mutable_clip()->mutable_box_high(), 20, 20, 20);
  auto* plane = scene.mutable_clip()->add_planes();
  test::set(plane->mutable_point(), 10, 0, 0);
  test::set(plane->mutable_normal(), 1, 0, 0);
  auto& slices = *scene.mutable_slices();
  for (auto* slice :
       {slices.mutable_sagittal(), slices.mutable_coronal(), slices.mutable_axial()}) {
    slice->set_shown(true);
    slice->set_position(3);
  }
  slices.set_window_centre(1000);
  slices.set_window_width(2000);
  scene.mutable_display()->set_exposure(0.5);
  test::set(scene.mutable_display()->mutable_background(), 0.1, 0.1, 0.1);
  return scene;
}

/// Returns one light of each shape.
std::vector<diaphane::v1::Light> lights_of_all_shapes() {
  std::vector<diaphane::v1::Light> lights(5);
  for (auto& light : lights) light.set_intensity(2);
  auto* rectangle = lights[0].mutable_rectangle();
  test::set(rectangle->mutable_corner(), -20, 15, 70);
  test::set(rectangle->mutable_u(), 0, 40, 0);
  test::set(rectangle->mutable_v(), 40, 0, 0);
  test::set(rectangle->mutable_radiance(), 3, 3, 3);
  test::set(lights[1].mutable_environment()->mutable_radiance(), 1, 1, 1);
  auto* disk = lights[2].mutable_disk();
  test::set(disk->mutable_centre(), 0, 0, 70);
  test::set(disk->mutable_normal(), 0, 0, -1);
  disk->set_radius(20);
  test::set(disk->mutable_radiance(), 3, 3, 3);
  auto* sphere = lights[3].mutable_sphere();
  test::set(sphere->mutable_centre(), 0, 0, 70);
  sphere->set_radius(20);
  test::set(sphere->mutable_radiance(), 3, 3, 3);
  auto* box = lights[4].mutable_box();
  test::set(box->mutable_corner(), 0, 0, 70);
  test::set(box->mutable_u(), 10, 0, 0);
  test::set(box->mutable_v(), 0, 10, 0);
  test::set(box->mutable_w(), 0, 0, 10);
  test::set(box->mutable_radiance(), 3, 3, 3);
  return lights;
}

/// Lists every double that a message of this type can hold.
void list_numbers(const Descriptor* type, std::set<const Descriptor*>& seen,
                  std::set<const FieldDescriptor*>& numbers) {
  if (!seen.insert(type).second) return;
  for (int i = 0; i < type->field_count(); ++i) {
    const FieldDescriptor* field = type->field(i);
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      list_numbers(field->message_type(), seen, numbers);
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
      numbers.insert(field);
    }
  }
}

/// Sets each double of `message` in turn, calls `check` with its path, and restores it.
void for_each_number(Message& message, const std::string& path, double value,
                     std::set<const FieldDescriptor*>& met,
                     const std::function<void(const std::string&)>& check) {
  const auto* reflection = message.GetReflection();
  const Descriptor* type = message.GetDescriptor();
  for (int i = 0; i < type->field_count(); ++i) {
    const FieldDescriptor* field = type->field(i);
    const std::string name = path + (path.empty() ? "" : ".") + field->json_name();
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
      const double before = reflection->GetDouble(message, field);
      reflection->SetDouble(&message, field, value);
      met.insert(field);
      check(name);
      reflection->SetDouble(&message, field, before);
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE && field->is_repeated()) {
      for (int n = 0; n < reflection->FieldSize(message, field); ++n) {
        for_each_number(*reflection->MutableRepeatedMessage(&message, field, n),
                        name + "[" + std::to_string(n) + "]", value, met, check);
      }
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE &&
               reflection->HasField(message, field)) {
      for_each_number(*reflection->MutableMessage(&message, field), name, value, met, check);
    }
  }
}

struct Tally {
  std::uint64_t asked = 0, accepted = 0;
  std::string first_accepted;
  std::set<const FieldDescriptor*> met;
};

/// Offers a bad scene to `renderer`, which already has a picture that must not change.
void offer(FrameRenderer& renderer, diaphane::v1::Scene scene, Tally& tally, StabilityRow& row) {
  PictureRgbF before, after;
  const auto broken = [&](const std::string& what) {
    row.passed = false;
    if (row.note.empty()) row.note = what;
  };
  if (!renderer.radiance(before)) return broken("no picture");
  const std::uint64_t samples = renderer.progress().samples;
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), infinity, -infinity}) {
    for_each_number(scene, "", value, tally.met, [&](const std::string& field) {
      ++tally.asked;
      const auto set = renderer.set_scene(scene, kCanvas);
      if (set) {
        if (tally.accepted++ == 0) tally.first_accepted = field;
        return;
      }
      // The error must name the field itself or a message that contains it.
      const std::string& named = set.error().field;
      if (named.empty() || field.compare(0, named.size(), named) != 0) {
        broken(field + " was refused as '" + named + "'");
      }
    });
    if (tally.accepted > 0) return;  // later pictures would show another scene
  }
  if (!renderer.radiance(after) || renderer.progress().samples != samples ||
      after.pixels != before.pixels) {
    broken("the picture did not stay");
  }
}

void refuses(Engine& engine, const StabilityOptions&, StabilityRow& row) {
  auto loaded = engine.load(test::skull_volume());
  if (!loaded) {
    row.passed = false;
    row.note = loaded.error().message;
    return;
  }
  Tally tally;
  std::string shapes_left_out;
  std::vector<diaphane::v1::Light> lights = lights_of_all_shapes();
  for (const auto& light : lights) {
    diaphane::v1::Scene scene = full_scene();
    *scene.add_lights() = light;
    auto renderer = engine.renderer(*loaded, 1, 0);
    if (!renderer || !(*renderer)->set_scene(scene, kCanvas) ||
        !(*renderer)->render(4, [] { return false; })) {
      shapes_left_out += " " + std::to_string(static_cast<int>(light.shape_case()));
      continue;
    }
    row.samples += 4.0 * kCanvas.width * kCanvas.height;
    offer(**renderer, scene, tally, row);
  }
  std::set<const Descriptor*> seen;
  std::set<const FieldDescriptor*> numbers;
  list_numbers(diaphane::v1::Scene::descriptor(), seen, numbers);
  for (const FieldDescriptor* field : numbers) {
    if (!tally.met.contains(field)) {
      row.passed = false;
      row.note += (row.note.empty() ? "" : "; ") + field->full_name() + " was never offered";
    }
  }
  if (tally.accepted > 0) row.note = tally.first_accepted + " was accepted";
  if (!shapes_left_out.empty()) row.note += "; light shapes without a picture:" + shapes_left_out;
  if (row.note.empty()) row.note = std::to_string(tally.asked) + " scenes offered, each refused";
  note_deviation(static_cast<double>(tally.accepted), 0, "fields", row);
}

}  // namespace

std::vector<StabilityCase> input_cases() {
  return {{"NaN, inf, -inf in every number of the scene", refuses}};
}

}  // namespace diaphane::render::bench
