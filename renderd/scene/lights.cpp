#include "renderd/scene/lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "common/try.h"
#include "renderd/scene/texture_store.h"

namespace diaphane::render {
namespace {

constexpr double kEvenShare = 1.0 / 16;

/// Transforms the frame in which a light is defined, the world or the camera, to the volume's
/// frame.
class Placement {
 public:
  Placement(bool locked, const CameraAxes& axes, Double3 target, const WorldToFrame& frame)
      : locked_(locked), axes_(axes), target_(target), frame_(frame) {}

  Double3 point(const diaphane::v1::Vec3& p) const {
    return frame_.point(locked_ ? target_ + axes_.to_world(vector_of(p)) : vector_of(p));
  }
  Double3 origin() const { return point(diaphane::v1::Vec3{}); }
  Double3 direction(Double3 v) const { return frame_.direction(locked_ ? axes_.to_world(v) : v); }
  Double3 direction(const diaphane::v1::Vec3& v) const { return direction(vector_of(v)); }

  /// Right, forward and up of a texture: in the world as the patient is seen from the front, or in
  /// the picture if the light is locked to the camera.
  Double3 right() const { return direction(Double3{1, 0, 0}); }
  Double3 forward() const { return direction(locked_ ? Double3{0, 0, -1} : Double3{0, 1, 0}); }
  Double3 up() const { return direction(locked_ ? Double3{0, 1, 0} : Double3{0, 0, 1}); }

 private:
  bool locked_;
  const CameraAxes& axes_;
  Double3 target_;
  const WorldToFrame& frame_;
};

/// Makes a parallelogram light as AreaLight stores it.
AreaLight flat_light(Double3 corner, Double3 u, Double3 v) {
  const Double3 normal = cross(u, v);
  AreaLight out{};
  out.corner = to_float(corner);
  out.u = to_float(u);
  out.v = to_float(v);
  out.normal = to_float(normalize(normal));
  out.area = static_cast<float>(length(normal));
  out.shape = LightShape::kRectangle;
  return out;
}

/// Returns the area of a disk, or of a sphere as seen from a distance; a point counts as 1 mm^2.
float round_area(double radius) {
  return radius > 0 ? static_cast<float>(std::numbers::pi * radius * radius) : 1.0f;
}

AreaLight disk_of(const diaphane::v1::DiskLight& d, const Placement& place) {
  const Double3 normal = normalize(place.direction(d.normal()));
  Double3 up = place.up() - normal * dot(place.up(), normal);
  if (length(up) < 1e-6) up = place.forward() - normal * dot(place.forward(), normal);
  up = normalize(up);
  AreaLight out{};
  out.shape = LightShape::kDisk;
  out.corner = to_float(place.point(d.centre()));
  out.u = to_float(cross(up, normal) * d.radius());
  out.v = to_float(up * d.radius());
  out.normal = to_float(normal);
  out.area = round_area(d.radius());
  return out;
}

AreaLight sphere_of(const diaphane::v1::SphereLight& s, const Placement& place) {
  AreaLight out{};
  out.shape = LightShape::kSphere;
  out.corner = to_float(place.point(s.centre()));
  out.u = to_float(place.right() * s.radius());
  out.v = to_float(place.forward() * -s.radius());
  out.normal = to_float(place.up());
  out.area = round_area(s.radius());
  return out;
}

/// Returns six rectangles that shine outwards.
std::vector<AreaLight> box_of(const diaphane::v1::BoxLight& b, const Placement& place) {
  const Double3 corner = place.point(b.corner());
  const Double3 edges[] = {place.direction(b.u()), place.direction(b.v()), place.direction(b.w())};
  const bool mirrored = dot(cross(edges[0], edges[1]), edges[2]) < 0;
  std::vector<AreaLight> faces;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Double3 a = edges[(axis + 1) % 3], b2 = edges[(axis + 2) % 3];
    // cross(a, b2) points along the edge of `axis` unless the box is mirrored.
    const Double3 first = mirrored ? b2 : a, second = mirrored ? a : b2;
    faces.push_back(flat_light(corner + edges[axis], first, second));
    faces.push_back(flat_light(corner, second, first));
  }
  return faces;
}

/// Lets a rectangle or disk project its texture. `origin` is that of the light's frame.
AreaLight projecting(AreaLight light, double degrees, Double3 middle, Double3 origin) {
  if (!(degrees > 0) || !(dot(light.u, light.u) > 0)) return light;
  const Double3 normal{light.normal.x, light.normal.y, light.normal.z};
  const double distance = dot(origin - middle, normal);
  // A light that does not face the origin has no plane of its own to focus on.
  const double focus = distance > 1 ? distance : std::max(length(origin - middle), 1.0);
  light.focus = static_cast<float>(focus);
  light.per_mm =
      static_cast<float>(0.5 / (focus * std::tan(0.5 * degrees * std::numbers::pi / 180)));
  if (light.shape == LightShape::kDisk) {  // its texture is upright from the other side
    light.u = light.u * -1.0f;
    light.v = light.v * -1.0f;
  }
  return light;
}

/// Properties that lights of all shapes have.
struct Appearance {
  Double3 radiance;  ///< radiance with the light's intensity included
  const std::string* texture = nullptr;
  bool stored = false;  ///< `texture` is the ID of a stored environment
  double rotation = 0;  ///< rotation of an environment's texture in degrees
};
template <typename Shape>
Appearance appearance_of(const Shape& shape, double intensity) {
  const auto& c = shape.radiance();
  return {Double3{c.r(), c.g(), c.b()} * (intensity > 0 ? intensity : 1.0),
          shape.has_texture() ? &shape.texture().picture() : nullptr};
}
Appearance appearance_of(const diaphane::v1::EnvironmentLight& light, double intensity) {
  Appearance looks = appearance_of<diaphane::v1::EnvironmentLight>(light, intensity);
  looks.rotation = light.rotation_degrees();
  if (light.stored().empty()) return looks;
  looks.texture = &light.stored();
  looks.stored = true;
  return looks;
}

struct Shaped {
  Appearance looks;
  const char* name = "";  ///< name of the field
  std::vector<AreaLight> parts;
};
Shaped shaped(const diaphane::v1::Light& light, const Placement& place) {
  switch (light.shape_case()) {
    case diaphane::v1::Light::kRectangle: {
      const auto& r = light.rectangle();
      const Double3 corner = place.point(r.corner());
      const Double3 u = place.direction(r.u()), v = place.direction(r.v());
      return {appearance_of(r, light.intensity()),
              ".rectangle",
              {projecting(flat_light(corner, u, v), r.texture().projection_degrees(),
                          corner + (u + v) * 0.5, place.origin())}};
    }
    case diaphane::v1::Light::kDisk: {
      const auto& d = light.disk();
      return {appearance_of(d, light.intensity()),
              ".disk",
              {projecting(disk_of(d, place), d.texture().projection_degrees(),
                          place.point(d.centre()), place.origin())}};
    }
    case diaphane::v1::Light::kSphere:
      return {appearance_of(light.sphere(), light.intensity()),
              ".sphere",
              {sphere_of(light.sphere(), place)}};
    case diaphane::v1::Light::kBox:
      return {appearance_of(light.box(), light.intensity()), ".box", box_of(light.box(), place)};
    case diaphane::v1::Light::kEnvironment:
    case diaphane::v1::Light::SHAPE_NOT_SET:
      break;
  }
  return {appearance_of(light.environment(), light.intensity()), ".environment", {}};
}

double sum(Double3 c) { return c.x + c.y + c.z; }

/// Returns a light's texture and the field it comes from, or nullopt if it has no texture or gives
/// no light.
std::optional<TextureFile> texture_of(const Appearance& looks, const char* name, int light) {
  if (looks.texture == nullptr || !(sum(looks.radiance) > 0)) return std::nullopt;
  return TextureFile{
      looks.texture,
      "lights[" + std::to_string(light) + "]" + name + (looks.stored ? ".stored" : ".texture"),
      looks.stored};
}

/// Sets `probability` and `cumulative`. The probability is the difference of two rounded cumulative
/// values, so it is exactly the one with which the light is chosen.
template <typename Light>
void share_out(std::vector<Light>& lights, const std::vector<double>& powers) {
  double total = 0;
  for (const double p : powers) total += p;
  const double even = kEvenShare / static_cast<double>(lights.size());
  double so_far = 0;
  float before = 0;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    so_far += (1 - kEvenShare) * powers[i] / total + even;
    lights[i].cumulative = i + 1 == lights.size() ? 1.0f : static_cast<float>(so_far);
    lights[i].probability = lights[i].cumulative - before;
    before = lights[i].cumulative;
  }
}

/// Collects the lights one by one.
class Collector {
 public:
  explicit Collector(std::shared_ptr<const PreparedTextures> textures) {
    out_.textures = std::move(textures);
  }

  void add(const Shaped& light, const Placement& place) {
    std::uint32_t texture = kNoTexture;
    if (light.looks.texture != nullptr) {
      texture = texture_index(*out_.textures, *light.looks.texture);
    }
    if (light.parts.empty()) return add_environment(light.looks, texture, place);
    for (const AreaLight& part : light.parts) add_area(part, light.looks.radiance, texture);
  }

  PreparedLights take() && {
    share_out(out_.area, powers_);
    share_out(out_.maps, map_powers_);
    return std::move(out_);
  }

 private:
  void add_environment(const Appearance& looks, std::uint32_t texture, const Placement& place) {
    const Double3 radiance = looks.radiance;
    if (texture == kNoTexture) {
      out_.environment += to_float(radiance);
      return;
    }
    const double power = sum(radiance * out_.textures->sky_means[texture]);
    if (!(power > 0)) return;
    EnvironmentMap map{};
    const double turn = looks.rotation * std::numbers::pi / 180;
    const Double3 right = place.right(), forward = place.forward();
    map.right = to_float(right * std::cos(turn) - forward * std::sin(turn));
    map.middle = to_float(forward * std::cos(turn) + right * std::sin(turn));
    map.up = to_float(place.up());
    map.radiance = to_float(radiance);
    map.texture = texture;
    out_.maps.push_back(map);
    map_powers_.push_back(power);
  }

  void add_area(AreaLight light, Double3 radiance, std::uint32_t texture) {
    const bool sphere = light.shape == LightShape::kSphere;
    Double3 mean{1, 1, 1};
    if (texture != kNoTexture) {
      mean = sphere ? out_.textures->sky_means[texture] : out_.textures->means[texture];
    }
    // A sphere emits from four times the area that is visible of it.
    const double power =
        (sphere ? 4.0 : 1.0) * static_cast<double>(light.area) * sum(radiance * mean);
    if (!(power > 0)) return;
    light.radiance = to_float(radiance);
    light.texture = texture;
    out_.area.push_back(light);
    powers_.push_back(power);
  }

  PreparedLights out_;
  std::vector<double> powers_, map_powers_;
};

}  // namespace

Result<PreparedLights> prepare_lights(const diaphane::v1::Scene& scene, const CameraAxes& axes,
                                      const WorldToFrame& frame,
                                      const std::shared_ptr<const PreparedTextures>& before) {
  const Double3 target = vector_of(scene.camera().target());
  std::vector<std::pair<Shaped, Placement>> lights;
  std::vector<TextureFile> files;
  for (int i = 0; i < scene.lights_size(); ++i) {
    if (scene.lights(i).disabled()) continue;
    const Placement place(scene.lights(i).camera_locked(), axes, target, frame);
    Shaped light = shaped(scene.lights(i), place);
    if (!(sum(light.looks.radiance) > 0)) continue;
    if (auto file = texture_of(light.looks, light.name, i)) files.push_back(std::move(*file));
    lights.emplace_back(std::move(light), place);
  }
  auto textures = prepare_textures(files, before);
  DIAPHANE_TRY(textures);
  Collector collector(*std::move(textures));
  for (const auto& [light, place] : lights) collector.add(light, place);
  return std::move(collector).take();
}

std::vector<TextureFile> texture_files(const diaphane::v1::Scene& scene) {
  std::vector<TextureFile> files;
  for (int i = 0; i < scene.lights_size(); ++i) {
    const diaphane::v1::Light& light = scene.lights(i);
    if (light.disabled()) continue;
    const auto add = [&](const auto& shape, const char* name) {
      if (auto file = texture_of(appearance_of(shape, light.intensity()), name, i)) {
        files.push_back(std::move(*file));
      }
    };
    switch (light.shape_case()) {
      case diaphane::v1::Light::kRectangle:
        add(light.rectangle(), ".rectangle");
        break;
      case diaphane::v1::Light::kDisk:
        add(light.disk(), ".disk");
        break;
      case diaphane::v1::Light::kSphere:
        add(light.sphere(), ".sphere");
        break;
      case diaphane::v1::Light::kBox:
        add(light.box(), ".box");
        break;
      case diaphane::v1::Light::kEnvironment:
        add(light.environment(), ".environment");
        break;
      case diaphane::v1::Light::SHAPE_NOT_SET:
        break;
    }
  }
  return files;
}

Features features_of(const PreparedLights& lights) {
  const Float3 sky = lights.environment;
  const auto any = [&lights](auto&& what) {
    return std::any_of(lights.area.begin(), lights.area.end(), what);
  };
  return Features{}
      .with(Feature::kAreaLights, !lights.area.empty())
      .with(Feature::kManyLights, lights.area.size() > 1)
      .with(Feature::kShapedLights,
            any([](const AreaLight& l) { return l.shape != LightShape::kRectangle; }))
      .with(Feature::kTexturedLights,
            any([](const AreaLight& l) { return l.texture != kNoTexture; }))
      .with(Feature::kEnvironment, sky.x > 0 || sky.y > 0 || sky.z > 0)
      .with(Feature::kTexturedEnvironment, !lights.maps.empty());
}

}  // namespace diaphane::render
