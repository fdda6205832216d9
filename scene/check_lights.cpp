#include <algorithm>
#include <string>

#include "common/ids.h"
#include "scene/check.h"

namespace diaphane::scene {
namespace {

using scene::check;  // in addition to the functions below

constexpr int kMostLights = 4096;
constexpr double kShortestEdge = 1e-6;  // mm

Complaint check_radiance(const diaphane::v1::Rgb& radiance, const std::string& field) {
  return check(radiance, kBrightest, field + ".radiance", "must be from 0 to 1e15");
}

/// Checks the size and header of a texture. Decoding finds any other error.
template <typename Shape>
Complaint check_texture(const Shape& shape, const std::string& field, PictureCheck check_picture) {
  if (!shape.has_texture()) return {};
  if (auto c = in_range(shape.texture().projection_degrees(), 0, 170,
                        field + ".texture.projectionDegrees",
                        "must be from 0 (which means no projection) to 170")) {
    return c;
  }
  const auto known = check_picture(shape.texture().picture());
  if (known) return {};
  Complaint complaint = complain(field + ".texture", known.error().message);
  complaint->code = known.error().code;
  return complaint;
}

Complaint check_edge(const diaphane::v1::Vec3& edge, const std::string& field) {
  if (auto c = check(edge, field)) return c;
  if (length(vector_of(edge)) >= kShortestEdge) return {};
  return complain(field, "must be at least 1e-6 mm long");
}

Complaint check_radius(double radius, const std::string& field) {
  if (radius == 0) return {};
  return in_range(radius, kShortestEdge, kLongestDistance, field + ".radius",
                  "must be 0 (a point) or from 1e-6 to 1e7 mm");
}

Complaint check(const diaphane::v1::RectangleLight& light, const std::string& field) {
  if (auto c = check(light.corner(), field + ".corner")) return c;
  if (auto c = check_edge(light.u(), field + ".u")) return c;
  if (auto c = check_edge(light.v(), field + ".v")) return c;
  const Vector u = vector_of(light.u()), v = vector_of(light.v());
  if (!(length(cross(u, v)) > 1e-6 * length(u) * length(v))) {
    return complain(field + ".v", "must not be parallel to u");
  }
  return check_radiance(light.radiance(), field);
}

Complaint check(const diaphane::v1::DiskLight& light, const std::string& field) {
  if (auto c = check(light.centre(), field + ".centre")) return c;
  if (auto c = check(light.normal(), field + ".normal")) return c;
  if (!(length(vector_of(light.normal())) >= 1e-6)) {
    return complain(field + ".normal", "must be a direction with a length of at least 1e-6");
  }
  if (auto c = check_radius(light.radius(), field)) return c;
  return check_radiance(light.radiance(), field);
}

Complaint check(const diaphane::v1::SphereLight& light, const std::string& field) {
  if (auto c = check(light.centre(), field + ".centre")) return c;
  if (auto c = check_radius(light.radius(), field)) return c;
  return check_radiance(light.radiance(), field);
}

Complaint check(const diaphane::v1::BoxLight& light, const std::string& field) {
  if (auto c = check(light.corner(), field + ".corner")) return c;
  if (auto c = check_edge(light.u(), field + ".u")) return c;
  if (auto c = check_edge(light.v(), field + ".v")) return c;
  if (auto c = check_edge(light.w(), field + ".w")) return c;
  const Vector u = vector_of(light.u()), v = vector_of(light.v()), w = vector_of(light.w());
  if (!(length(cross(u, v)) > 1e-6 * length(u) * length(v))) {
    return complain(field + ".v", "must not be parallel to u");
  }
  const double volume = dot(cross(u, v), w);
  if (!(std::max(volume, -volume) > 1e-6 * length(cross(u, v)) * length(w))) {
    return complain(field + ".w", "must not lie in the plane of u and v");
  }
  return check_radiance(light.radiance(), field);
}

Complaint check(const diaphane::v1::EnvironmentLight& light, const std::string& field) {
  if (!light.stored().empty() && !is_id(light.stored())) {
    return complain(field + ".stored", "must be the ID of a stored environment");
  }
  if (!light.stored().empty() && light.has_texture()) {
    return complain(field + ".stored", "must not be combined with a texture");
  }
  if (auto c = in_range(light.rotation_degrees(), -360, 360, field + ".rotationDegrees",
                        "must be from -360 to 360")) {
    return c;
  }
  return check_radiance(light.radiance(), field);
}

Complaint check_texture(const diaphane::v1::Light& light, const std::string& field,
                        PictureCheck check_picture) {
  switch (light.shape_case()) {
    case diaphane::v1::Light::kRectangle:
      return check_texture(light.rectangle(), field + ".rectangle", check_picture);
    case diaphane::v1::Light::kEnvironment:
      return check_texture(light.environment(), field + ".environment", check_picture);
    case diaphane::v1::Light::kDisk:
      return check_texture(light.disk(), field + ".disk", check_picture);
    case diaphane::v1::Light::kSphere:
      return check_texture(light.sphere(), field + ".sphere", check_picture);
    case diaphane::v1::Light::kBox:
      return check_texture(light.box(), field + ".box", check_picture);
    case diaphane::v1::Light::SHAPE_NOT_SET:
      break;
  }
  return {};
}

Complaint check_shape(const diaphane::v1::Light& light, const std::string& field) {
  switch (light.shape_case()) {
    case diaphane::v1::Light::kRectangle:
      return check(light.rectangle(), field + ".rectangle");
    case diaphane::v1::Light::kEnvironment:
      return check(light.environment(), field + ".environment");
    case diaphane::v1::Light::kDisk:
      return check(light.disk(), field + ".disk");
    case diaphane::v1::Light::kSphere:
      return check(light.sphere(), field + ".sphere");
    case diaphane::v1::Light::kBox:
      return check(light.box(), field + ".box");
    case diaphane::v1::Light::SHAPE_NOT_SET:
      break;
  }
  return complain(field, "needs a shape");
}

double brightest_of(const diaphane::v1::Rgb& c) { return std::max({c.r(), c.g(), c.b()}); }

double brightest_of(const diaphane::v1::Light& light) {
  switch (light.shape_case()) {
    case diaphane::v1::Light::kRectangle:
      return brightest_of(light.rectangle().radiance());
    case diaphane::v1::Light::kEnvironment:
      return brightest_of(light.environment().radiance());
    case diaphane::v1::Light::kDisk:
      return brightest_of(light.disk().radiance());
    case diaphane::v1::Light::kSphere:
      return brightest_of(light.sphere().radiance());
    case diaphane::v1::Light::kBox:
      return brightest_of(light.box().radiance());
    case diaphane::v1::Light::SHAPE_NOT_SET:
      break;
  }
  return 0;
}

Complaint check(const diaphane::v1::Light& light, const std::string& field,
                PictureCheck check_picture) {
  if (auto c = check_shape(light, field)) return c;
  if (auto c = check_texture(light, field, check_picture)) return c;
  if (auto c = in_range(light.intensity(), 0, kBrightest, field + ".intensity",
                        "must be 0 (which means 1) or at most 1e15")) {
    return c;
  }
  return in_range(light.intensity() * brightest_of(light), 0, kBrightest, field + ".intensity",
                  "times the radiance must be at most 1e15");
}

}  // namespace

Complaint check_lights(const diaphane::v1::Scene& scene, PictureCheck check_picture) {
  if (scene.lights_size() > kMostLights) return complain("lights", "must have at most 4096 lights");
  for (int i = 0; i < scene.lights_size(); ++i) {
    const std::string field = "lights[" + std::to_string(i) + "]";
    if (auto c = check(scene.lights(i), field, check_picture)) return c;
  }
  return {};
}

}  // namespace diaphane::scene
