#include <cmath>
#include <set>
#include <string>

#include "scene/check.h"

namespace diaphane::scene {
namespace {

using scene::check;  // in addition to the functions below

constexpr int kMostChannels = 64;
constexpr int kMostPoints = 1024;
constexpr int kMostPlanes = 6;
constexpr int kMostLabels = 256;
constexpr std::uint32_t kMostBounces = 1024;
constexpr double kDensest = 1e7;  // per mm

Complaint check(const diaphane::v1::Channel& channel, const std::string& field) {
  if (channel.opacity_size() < 2 || channel.opacity_size() > kMostPoints) {
    return complain(field + ".opacity", "needs 2 to 1024 points");
  }
  for (int i = 0; i < channel.opacity_size(); ++i) {
    const std::string point = field + ".opacity[" + std::to_string(i) + "]";
    const auto& p = channel.opacity(i);
    if (auto c = in_range(p.value(), -1e9, 1e9, point + ".value", "must be from -1e9 to 1e9")) {
      return c;
    }
    if (auto c = in_range(p.opacity(), 0, 1, point + ".opacity", "must be from 0 to 1")) return c;
    if (i > 0 && !(p.value() > channel.opacity(i - 1).value())) {
      return complain(point + ".value", "must be greater than the value of the previous point");
    }
  }
  if (auto c = check(channel.diffuse(), 1, field + ".diffuse", "must be from 0 to 1")) return c;
  if (auto c = check(channel.specular(), 1, field + ".specular", "must be from 0 to 1")) return c;
  if (auto c = in_range(channel.gloss(), 0, 1, field + ".gloss", "must be from 0 to 1")) return c;
  return check(channel.emission(), kBrightest, field + ".emission", "must be from 0 to 1e15");
}

Complaint check(const diaphane::v1::TransferFunction& function, const std::string& field) {
  if (function.channels_size() == 0 || function.channels_size() > kMostChannels) {
    return complain(field + ".channels", "needs 1 to 64 channels");
  }
  for (int i = 0; i < function.channels_size(); ++i) {
    if (auto c = check(function.channels(i), field + ".channels[" + std::to_string(i) + "]")) {
      return c;
    }
  }
  return in_range(function.extinction_per_mm(), 0, kDensest, field + ".extinctionPerMm",
                  "must be from 0 to 1e7 per mm");
}

Complaint check(const diaphane::v1::Camera& camera) {
  if (auto c = check(camera.eye(), "camera.eye")) return c;
  if (auto c = check(camera.target(), "camera.target")) return c;
  if (auto c = check(camera.up(), "camera.up")) return c;
  const Vector back = vector_of(camera.eye()) - vector_of(camera.target());
  const Vector up = vector_of(camera.up());
  if (!(length(back) >= 1e-6))
    return complain("camera.target", "must not be at the position of the eye");
  if (!(length(cross(up, back)) > 1e-9 * length(up) * length(back))) {
    return complain("camera.up", "must not be zero or parallel to the view direction");
  }
  if (auto c = in_range(camera.orthographic_height(), 0, kLongestDistance,
                        "camera.orthographicHeight", "must be from 0 to 1e7 mm")) {
    return c;
  }
  // An orthographic camera does not use the field of view.
  const double least_fov = camera.orthographic_height() > 0 ? 0 : 1e-3;
  if (auto c = in_range(camera.vertical_fov_degrees(), least_fov, 179.9,
                        "camera.verticalFovDegrees", "must be from 0.001 to 179.9 degrees")) {
    return c;
  }
  if (auto c = in_range(camera.aperture_radius(), 0, kLongestDistance, "camera.apertureRadius",
                        "must be from 0 to 1e7 mm")) {
    return c;
  }
  const double focus = camera.focal_distance();
  if (focus == 0) return {};
  return in_range(focus, 1e-6, kLongestDistance, "camera.focalDistance",
                  "must be 0 (the distance to the target) or from 1e-6 to 1e7 mm");
}

Complaint check(const diaphane::v1::Clip& clip) {
  if (clip.has_box_low() != clip.has_box_high()) {
    return complain(clip.has_box_low() ? "clip.boxHigh" : "clip.boxLow",
                    "is missing; a box needs both corners");
  }
  if (auto c = check(clip.box_low(), "clip.boxLow")) return c;
  if (auto c = check(clip.box_high(), "clip.boxHigh")) return c;
  const Vector low = vector_of(clip.box_low()), high = vector_of(clip.box_high());
  for (int axis = 0; axis < 3; ++axis) {
    if (high[axis] >= low[axis]) continue;
    return complain(std::string("clip.boxHigh.") + "xyz"[axis], "must not be below that of boxLow");
  }
  if (clip.planes_size() > kMostPlanes)
    return complain("clip.planes", "must have at most 6 planes");
  for (int i = 0; i < clip.planes_size(); ++i) {
    const std::string field = "clip.planes[" + std::to_string(i) + "]";
    if (auto c = check(clip.planes(i).point(), field + ".point")) return c;
    if (auto c = check(clip.planes(i).normal(), field + ".normal")) return c;
    if (!(length(vector_of(clip.planes(i).normal())) >= 1e-6)) {
      return complain(field + ".normal", "must be a direction with a length of at least 1e-6");
    }
  }
  return {};
}

Complaint check(const diaphane::v1::Slices& slices) {
  const std::pair<const char*, const diaphane::v1::Slices::Slice*> all[] = {
      {"slices.sagittal", &slices.sagittal()},
      {"slices.coronal", &slices.coronal()},
      {"slices.axial", &slices.axial()}};
  bool shown = false;
  for (const auto& [field, slice] : all) {
    if (auto c = in_range(slice->position(), -kLongestDistance, kLongestDistance,
                          field + std::string(".position"), "must be from -1e7 to 1e7 mm")) {
      return c;
    }
    shown = shown || slice->shown();
  }
  if (slices.colouring() != diaphane::v1::Slices::GREY &&
      slices.colouring() != diaphane::v1::Slices::TRANSFER) {
    return complain("slices.colouring", "must be GREY or TRANSFER");
  }
  if (auto c = in_range(slices.window_centre(), -1e9, 1e9, "slices.windowCentre",
                        "must be from -1e9 to 1e9")) {
    return c;
  }
  const bool grey = shown && slices.colouring() == diaphane::v1::Slices::GREY;
  return in_range(
      slices.window_width(), grey ? 1e-6 : 0, 1e9, "slices.windowWidth",
      grey ? "must be above 0 and at most 1e9 for grey slices" : "must be from 0 to 1e9");
}

Complaint check(const diaphane::v1::Display& display) {
  if (auto c =
          in_range(display.exposure(), -64, 64, "display.exposure", "must be from -64 to 64")) {
    return c;
  }
  if (!diaphane::v1::Display::Curve_IsValid(display.curve())) {
    return complain("display.curve", "must be LINEAR or FILMIC");
  }
  if (auto c = check(display.background_edge(), kBrightest, "display.backgroundEdge",
                     "must be from 0 to 1e15")) {
    return c;
  }
  return check(display.background(), kBrightest, "display.background", "must be from 0 to 1e15");
}

Complaint check(const diaphane::v1::Shading& shading) {
  if (!diaphane::v1::Shading::Mode_IsValid(shading.mode())) {
    return complain("shading.mode", "must be PHASE, SURFACE or HYBRID");
  }
  if (shading.gradient_scale() == 0) return {};
  return in_range(shading.gradient_scale(), 1e-9, 1e9, "shading.gradientScale",
                  "must be from 1e-9 to 1e9 per mm");
}

Complaint check_labels(const diaphane::v1::Scene& scene) {
  if (scene.labels_size() > kMostLabels) return complain("labels", "must be at most 256");
  std::set<std::uint32_t> numbers;
  for (int i = 0; i < scene.labels_size(); ++i) {
    const std::string field = "labels[" + std::to_string(i) + "]";
    const auto& look = scene.labels(i);
    if (!numbers.insert(look.number()).second) {
      return complain(field + ".number", "must not be that of another look");
    }
    if (auto c = check(look.colour(), 1, field + ".colour", "must be from 0 to 1")) return c;
    if (auto c = in_range(look.opacity(), 0, 1, field + ".opacity", "must be from 0 to 1")) {
      return c;
    }
  }
  return {};
}

Complaint check(const diaphane::v1::Highlight& highlight) {
  if (auto c = check(highlight.centre(), "highlight.centre")) return c;
  if (auto c = in_range(highlight.radius(), 1e-3, 1e6, "highlight.radius",
                        "must be from 0.001 to 1,000,000 mm")) {
    return c;
  }
  if (auto c = check(highlight.colour(), 1, "highlight.colour", "must be from 0 to 1")) return c;
  return in_range(highlight.strength(), 0, 1, "highlight.strength", "must be from 0 to 1");
}

Complaint check(const diaphane::v1::Overlay& overlay) {
  if (overlay.has_transfer_function()) {
    if (auto c = check(overlay.transfer_function(), "overlay.transferFunction")) return c;
  }
  if (auto c = in_range(overlay.share(), 0, 1, "overlay.share", "must be from 0 to 1")) return c;
  if (!diaphane::v1::Overlay::Mode_IsValid(overlay.mode())) {
    return complain("overlay.mode", "is not known");
  }
  return in_range(overlay.split(), 0, 1, "overlay.split", "must be from 0 to 1");
}

Complaint first_complaint(const diaphane::v1::Scene& scene, PictureCheck check_picture) {
  if (auto c = check(scene.transfer_function(), "transferFunction")) return c;
  if (auto c = check_lights(scene, check_picture)) return c;
  if (!scene.has_camera()) return complain("camera", "is missing");
  if (auto c = check(scene.camera())) return c;
  const double g = scene.phase().g();
  if (!(g > -1 && g < 1)) return complain("phase.g", "must be between -1 and 1");
  if (auto c = check(scene.display())) return c;
  if (auto c = check(scene.clip())) return c;
  if (auto c = check(scene.slices())) return c;
  if (auto c = check(scene.shading())) return c;
  if (auto c = check_labels(scene)) return c;
  if (scene.has_highlight()) {
    if (auto c = check(scene.highlight())) return c;
  }
  if (scene.has_overlay()) {
    if (auto c = check(scene.overlay())) return c;
  }
  if (scene.bounces() > kMostBounces) return complain("bounces", "must be at most 1024");
  return {};
}

}  // namespace

Result<void> no_pictures(std::string_view) {
  return fail(ErrorCode::kUnsupported, "must not be set; a preset does not store light textures");
}

Result<void> check_scene(const diaphane::v1::Scene& scene, PictureCheck check_picture) {
  if (auto complaint = first_complaint(scene, check_picture)) {
    return tl::unexpected(*std::move(complaint));
  }
  return {};
}

}  // namespace diaphane::scene
