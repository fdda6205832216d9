#include "renderd/scene/presets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <numbers>

namespace diaphane::render {
namespace {

namespace v1 = diaphane::v1;

struct Vector {
  double x, y, z;
};
Vector operator*(Vector a, double s) { return {a.x * s, a.y * s, a.z * s}; }
Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vector cross(Vector a, Vector b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double length(Vector a) { return std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z); }
Vector unit(Vector a) { return a * (1.0 / length(a)); }
void set(v1::Vec3& out, Vector a) {
  out.set_x(a.x);
  out.set_y(a.y);
  out.set_z(a.z);
}
void set(v1::Rgb& out, Vector a) {
  out.set_r(a.x);
  out.set_g(a.y);
  out.set_b(a.z);
}

struct Point {
  double value, opacity;
};

/// One material of a preset. The opacity of its last point extends to the largest value of the
/// volume.
struct PresetMaterial {
  const char* name;
  Vector albedo;
  std::initializer_list<Point> hounsfield;  ///< values for CT
  /// Values for other modalities: 0 is the 1st percentile, 1 the 99.9th.
  std::initializer_list<Point> fraction;
  bool open_ended;  ///< opacity stays constant beyond the last point
};

struct Look {
  const char* name;
  double extinction_per_mm;
  std::initializer_list<PresetMaterial> materials;
};

// Colours are single-scattering albedos and look paler than a surface of the same colour, because
// the light that one sees has scattered once and has passed through the tissue in front.
constexpr Vector kSkin{0.90, 0.60, 0.45};
constexpr Vector kMuscle{0.80, 0.30, 0.22};
constexpr Vector kFat{0.92, 0.76, 0.48};
constexpr Vector kVessel{0.88, 0.13, 0.11};
constexpr Vector kBone{0.95, 0.88, 0.74};
constexpr Vector kLining{0.62, 0.86, 0.95};

// Hounsfield units: air -1000, lung -850 to -700, fat -100, water 0, muscle 50, contrast 150 to
// 400, spongy bone from 200, compact bone from 600.
const Look kLooks[] = {
    {"skin",
     1.6,
     {{"skin", kSkin, {{-420, 0}, {-180, 0.55}, {60, 1}}, {{0.06, 0}, {0.16, 1}}, true}}},
    {"muscle",
     1.1,
     {{"fat",
       kFat,
       {{-140, 0}, {-80, 0.025}, {-20, 0}},
       {{0.10, 0}, {0.16, 0.03}, {0.24, 0}},
       false},
      {"muscle",
       kMuscle,
       {{5, 0}, {55, 0.75}, {180, 0.9}, {260, 0}},
       {{0.20, 0}, {0.36, 0.9}, {0.55, 0}},
       false},
      {"bone", kBone, {{180, 0}, {420, 1}}, {{0.50, 0}, {0.70, 1}}, true}}},
    {"vessels",
     1.4,
     {{"vessels",
       kVessel,
       {{130, 0}, {190, 0.35}, {280, 0.45}, {380, 0}},
       {{0.55, 0}, {0.70, 0.9}},
       true},
      {"bone", kBone, {{230, 0}, {480, 1}}, {{0.85, 0}, {1.0, 1}}, true}}},
    {"bone",
     1.2,
     {{"bone", kBone, {{140, 0}, {260, 0.35}, {600, 1}}, {{0.35, 0}, {0.60, 1}}, true}}},
    // The values between air and tissue. They are thin, because the skin has such values as well
    // and must not hide the walls within, which appear one behind the other.
    {"airways",
     1.4,
     {{"airways",
       kLining,
       {{-900, 0}, {-650, 0.12}, {-450, 0.12}, {-250, 0}},
       {{0.02, 0}, {0.05, 0.12}, {0.08, 0.12}, {0.12, 0}},
       false}}},
};

/// Half the diagonal of the volume's box, mm.
double radius_of(const volume::Header& header) {
  double squared = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double edge = header.size[axis] * header.spacing[axis];
    squared += edge * edge;
  }
  return 0.5 * std::sqrt(squared);
}

double value_of(const volume::Header& header, double fraction) {
  const double low = header.percentiles.front(), high = header.percentiles.back();
  return low + fraction * std::max(high - low, 1.0);
}

void fill_channel(const volume::Header& header, const PresetMaterial& material,
                  v1::Channel& channel) {
  const bool ct = header.modality == volume::Modality::kCt;
  channel.set_name(material.name);
  set(*channel.mutable_diffuse(), material.albedo);
  double last = 0, opacity = 0;
  for (const Point& point : ct ? material.hounsfield : material.fraction) {
    last = ct ? point.value : value_of(header, point.value);
    opacity = point.opacity;
    auto& to = *channel.add_opacity();
    to.set_value(last);
    to.set_opacity(opacity);
  }
  if (material.open_ended) {
    auto& to = *channel.add_opacity();
    to.set_value(std::max<double>(last, std::max<double>(header.maximum, 3071)) + 1);
    to.set_opacity(opacity);
  }
}

/// Adds a square light that faces the target, in the camera's frame (x right, y up, z towards the
/// eye). `irradiance` is that at the target.
void add_light(v1::Scene& scene, const char* name, double radius, Vector towards, double size,
               double irradiance, Vector tint) {
  const double distance = 3.2 * radius, edge = size * radius;
  const Vector facing = unit(towards) * -1.0;
  const Vector u = unit(cross({0, 1, 0}, facing)), v = cross(facing, u);
  v1::Light& light = *scene.add_lights();
  light.set_name(name);
  light.set_camera_locked(true);
  v1::RectangleLight& rectangle = *light.mutable_rectangle();
  set(*rectangle.mutable_corner(), facing * -distance + (u + v) * (-0.5 * edge));
  set(*rectangle.mutable_u(), u * edge);
  set(*rectangle.mutable_v(), v * edge);
  set(*rectangle.mutable_radiance(), tint * (irradiance * distance * distance / (edge * edge)));
}

v1::Scene scene_of(const volume::Header& header, const Look& look) {
  v1::Scene scene;
  scene.mutable_transfer_function()->set_extinction_per_mm(look.extinction_per_mm);
  for (const PresetMaterial& material : look.materials) {
    fill_channel(header, material, *scene.mutable_transfer_function()->add_channels());
  }

  const double radius = radius_of(header);
  add_light(scene, "key", radius, {-0.75, 0.95, 1.0}, 1.0, 15.0, {1.0, 0.97, 0.92});
  add_light(scene, "fill", radius, {1.0, 0.05, 0.75}, 2.0, 3.6, {0.88, 0.94, 1.0});
  v1::Light& sky = *scene.add_lights();
  sky.set_name("sky");
  set(*sky.mutable_environment()->mutable_radiance(), {0.26, 0.27, 0.29});

  // Closer than the bounding sphere of the box requires, since a scan rarely fills its corners. The
  // patient's face is in front, seen from slightly above.
  constexpr double kFov = 30;
  const double distance = 0.74 * radius / std::sin(0.5 * kFov * std::numbers::pi / 180);
  const Vector towards = unit({0, -1, 0.14});
  v1::Camera& camera = *scene.mutable_camera();
  set(*camera.mutable_eye(), towards * distance);
  set(*camera.mutable_target(), {0, 0, 0});
  set(*camera.mutable_up(), {0, 0, 1});
  camera.set_vertical_fov_degrees(kFov);

  scene.mutable_phase()->set_g(0);
  set(*scene.mutable_display()->mutable_background(), {0.010, 0.012, 0.015});
  return scene;
}

}  // namespace

std::vector<v1::Preset> presets_for(const volume::Header& header) {
  std::vector<v1::Preset> presets;
  for (const Look& look : kLooks) {
    v1::Preset& preset = presets.emplace_back();
    preset.set_name(look.name);
    *preset.mutable_scene() = scene_of(header, look);
  }
  return presets;
}

Result<v1::Preset> preset_for(const volume::Header& header, std::string_view name) {
  for (auto& preset : presets_for(header)) {
    if (preset.name() == name) return preset;
  }
  return fail(ErrorCode::kNotFound, "there is no preset with this name", "preset");
}

}  // namespace diaphane::render
