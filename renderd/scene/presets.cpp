#include "renderd/scene/presets.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <span>

namespace diaphane::render {
namespace {

namespace v1 = diaphane::v1;

/// Height of the picture, as a multiple of the height of what it shows. In a low window, the page's
/// controls cover a third of it, and the handles of the volume's box must stay clear of them.
constexpr double kMargin = 1.65;

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
using Curve = std::initializer_list<Point>;

struct Matter {
  const char* name;
  Vector albedo;
  double reflectance;  ///< reflectance of the glossy surface at normal incidence
  double gloss;
};

/// One material of a look: its properties, and its opacity by voxel value.
struct LookMaterial {
  Matter matter;
  Curve curve;
  bool open_ended;  ///< opacity stays constant beyond the last point
};

struct Look {
  std::string_view name;
  double extinction_per_mm;
  int bounces;
  double exposure;
  std::initializer_list<LookMaterial> materials;
};

constexpr std::string_view kVessels = "vessels", kDense = "dense", kAirways = "airways",
                           kBrain = "brain", kThrough = "through", kSkinLook = "skin";

/// The gradient of the opacity, per mm, at which two thirds of the collisions are with a surface:
/// low, so that all borders of organs are surfaces.
constexpr double kGradientScale = 0.05;

// A surface shows its albedo. In depth, light is scattered several times, which makes the colour
// darker and more saturated.
constexpr Matter kSkin{"skin", {0.82, 0.49, 0.36}, 0.030, 0.42};
constexpr Matter kFat{"fat", {0.92, 0.74, 0.42}, 0.040, 0.55};
constexpr Matter kMuscle{"muscle", {0.58, 0.13, 0.11}, 0.050, 0.62};
constexpr Matter kVessel{"vessels", {0.74, 0.07, 0.05}, 0.060, 0.70};
constexpr Matter kSpongyBone{"spongy bone", {0.90, 0.79, 0.60}, 0.040, 0.45};
constexpr Matter kBone{"bone", {0.95, 0.90, 0.80}, 0.045, 0.55};
constexpr Matter kEnamel{"enamel", {0.97, 0.94, 0.88}, 0.055, 0.75};
constexpr Matter kLining{"airways", {0.55, 0.82, 0.93}, 0.060, 0.70};
constexpr Matter kSurface{"surface", {0.83, 0.55, 0.43}, 0.030, 0.42};
constexpr Matter kMiddle{"middle", {0.82, 0.50, 0.40}, 0.040, 0.55};
constexpr Matter kGreyMatter{"grey matter", {0.86, 0.58, 0.50}, 0.050, 0.60};
constexpr Matter kWhiteMatter{"white matter", {0.94, 0.82, 0.74}, 0.040, 0.50};
constexpr Matter kBright{"bright", {0.94, 0.86, 0.74}, 0.040, 0.55};

constexpr double kInAirways = -650, kHardBone = 1300;

// Hounsfield units: air -1000, lung -850 to -700, fat -100, water 0, muscle 50, contrast 150 to
// 400, spongy bone from 200, compact bone from 600.
const Look kCtLooks[] = {
    // The skin is where the values rise from air to tissue. A cut shows the tissue beneath.
    {"skin",
     3.0,
     2,
     0.2,
     {{kSkin, {{-480, 0}, {-300, 0.7}, {-130, 0.8}, {-60, 0}}, false},
      {kFat, {{-160, 0}, {-110, 0.5}, {-40, 0.5}, {0, 0}}, false},
      {kMuscle, {{-40, 0}, {40, 0.9}, {160, 0.9}, {260, 0}}, false},
      {kBone, {{180, 0}, {420, 1}}, true}}},
    {"muscle",
     2.0,
     2,
     0.2,
     {{kMuscle, {{-20, 0}, {60, 0.8}, {180, 0.9}, {260, 0}}, false},
      {kBone, {{180, 0}, {420, 1}}, true}}},
    // Where values rise from tissue to bone, they pass those of vessels within half a millimetre.
    // This must not redden the bone, so vessels are thin matter, opaque only over some millimetres.
    {kVessels,
     2.5,
     2,
     0.2,
     {{kVessel, {{130, 0}, {190, 0.15}, {280, 0.3}, {380, 0.15}, {420, 0}}, false},
      {kBone, {{250, 0}, {500, 1}}, true}}},
    {"bone",
     2.5,
     3,
     0.2,
     {{kSpongyBone, {{140, 0}, {260, 0.35}, {500, 0.9}, {900, 0}}, false},
      {kBone, {{450, 0}, {900, 1}}, true}}},
    // Skin like glass around the bone. Thin matter keeps its shape visible, since it is densest
    // where the line of sight touches it.
    {kThrough,
     2.5,
     2,
     0.2,
     {{kSkin, {{-480, 0}, {-300, 0.02}, {-130, 0.02}, {-60, 0}}, false},
      {kBone, {{220, 0}, {450, 1}}, true}}},
    // Teeth, and the hard bone around the inner ear, within the rest of the bone.
    {kDense,
     2.5,
     2,
     0.2,
     {{kSpongyBone, {{200, 0}, {400, 0.01}, {1000, 0.01}, {1300, 0}}, false},
      {kEnamel, {{1300, 0}, {1700, 1}}, true}}},
    // The values between air and tissue. They are thin, because the skin has such values as well
    // and must not hide the walls within, which appear one behind the other.
    {kAirways, 1.4, 1, 0, {{kLining, {{-900, 0}, {-650, 0.05}, {-450, 0.05}, {-250, 0}}, false}}},
};

// Values of other modalities: 0 is the least, 1 is tissue, 2 the brightest (see value_of()).
const Look kOtherLooks[] = {
    {"skin",
     2.0,
     2,
     0.2,
     {{kSurface, {{0.20, 0}, {0.40, 0.8}, {0.60, 0.8}, {0.75, 0}}, false},
      {kMiddle, {{0.55, 0}, {0.70, 0.9}, {0.85, 0}}, false},
      {kBright, {{0.80, 0}, {0.95, 1}}, true}}},
    {"muscle",
     1.2,
     2,
     0.2,
     {{kMiddle, {{0.40, 0}, {0.60, 0.5}, {0.80, 0.8}, {0.92, 0}}, false},
      {kBright, {{0.84, 0}, {1.0, 1}}, true}}},
    {kVessels, 2.0, 2, 0.2, {{kVessel, {{1.2, 0}, {1.5, 0.9}}, true}}},
    {"bone", 2.0, 2, 0.2, {{kBright, {{0.75, 0}, {1.0, 1}}, true}}},
    {kAirways, 1.4, 1, 0, {{kLining, {{0.05, 0}, {0.10, 0.08}, {0.18, 0.08}, {0.26, 0}}, false}}},
};

// Curves for the brain, on a scale where 0 is the lowest value of the scan and 1 the brain's
// median. The fluid around a brain is dark, so the surface is where grey matter begins.
const Curve kGreyCurve{{0.50, 0}, {0.72, 0.9}, {0.98, 0.9}, {1.12, 0}};
const Curve kWhiteCurve{{0.98, 0}, {1.12, 1}};
/// The page tells looks apart by their transfer functions, so those of these two must differ.
constexpr double kBrainExtinction = 3.0, kBrainInGlassExtinction = 2.5;
/// Opacity of the matter around the brain in the look through it.
constexpr double kGlass = 0.010;

/// Returns half the diagonal of the box around what is framed, mm.
double radius_of(const Framing& framing) {
  const auto& half = framing.half_width;
  return std::hypot(half[0], half[1], half[2]);
}

/// The values of a scan that is not a CT.
struct Brightness {
  double least, tissue, most;
};

/// Returns the values of a scan. Tissue is what is brighter than nine tenths of the volume, unless
/// most of the volume is air.
Brightness brightness_of(const volume::Header& header) {
  const auto& at = header.percentiles;
  const double least = at[0], most = at[7] > least ? at[7] : least + 1;
  const double tissue = std::max(at[5], least + 0.6 * (at[6] - least));
  const double span = std::clamp(tissue - least, 0.05 * (most - least), 0.9 * (most - least));
  return {least, least + span, most};
}

/// Converts a value of kOtherLooks to a voxel value.
double value_of(const volume::Header& header, double level) {
  const auto [least, tissue, most] = brightness_of(header);
  return level <= 1 ? least + level * (tissue - least) : tissue + (level - 1) * (most - tissue);
}

/// Returns whether some parts are as much brighter than tissue as blood is in angiography.
bool has_bright_vessels(const volume::Header& header) {
  constexpr double kTimesTissue = 2.5;
  const auto [least, tissue, most] = brightness_of(header);
  return most - least > kTimesTissue * (tissue - least);
}

/// Adds a material whose curve `value_at` converts to voxel values.
template <typename ValueAt>
void fill_channel(const volume::Header& header, const LookMaterial& material, ValueAt value_at,
                  v1::Channel& channel) {
  const Matter& matter = material.matter;
  channel.set_name(matter.name);
  set(*channel.mutable_diffuse(), matter.albedo);
  set(*channel.mutable_specular(), Vector{1, 1, 1} * matter.reflectance);
  channel.set_gloss(matter.gloss);
  double last = 0, opacity = 0;
  for (const Point& point : material.curve) {
    last = value_at(point.value);
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

/// A square light that faces the target.
struct Lamp {
  const char* name;
  Vector towards;   ///< direction in the camera's frame (x right, y up, z towards the eye)
  double distance;  ///< distance from the target; like `edge`, in radii of what is framed
  double edge;
  double irradiance;  ///< irradiance at the target
  Vector tint;
};

void add_light(v1::Scene& scene, double radius, const Lamp& lamp) {
  const double distance = lamp.distance * radius, edge = lamp.edge * radius;
  const Vector facing = unit(lamp.towards) * -1.0;
  const Vector u = unit(cross({0, 1, 0}, facing)), v = cross(facing, u);
  v1::Light& light = *scene.add_lights();
  light.set_name(lamp.name);
  light.set_camera_locked(true);
  v1::RectangleLight& rectangle = *light.mutable_rectangle();
  set(*rectangle.mutable_corner(), facing * -distance + (u + v) * (-0.5 * edge));
  set(*rectangle.mutable_u(), u * edge);
  set(*rectangle.mutable_v(), v * edge);
  set(*rectangle.mutable_radiance(),
      lamp.tint * (lamp.irradiance * distance * distance / (edge * edge)));
}

/// Adds light like a photographer's: a warm key from the side and above, a cool rim from behind
/// that separates the outline from the background, and a sky so faint that shadows stay dark.
///
/// The sky replaces a third lamp, because each collision samples one lamp, chosen by power: a weak
/// lamp is sampled rarely, which makes shadows noisy. A stronger rim would take samples from the
/// key, since it is hidden from most places that the camera sees.
void add_lights(v1::Scene& scene, double radius) {
  add_light(scene, radius, {"key", {-0.90, 0.80, 0.75}, 3.2, 0.9, 6.0, {1.0, 0.93, 0.82}});
  add_light(scene, radius, {"rim", {0.85, 0.45, -0.75}, 4.0, 1.2, 0.9, {0.72, 0.86, 1.0}});
  v1::Light& sky = *scene.add_lights();
  sky.set_name("sky");
  set(*sky.mutable_environment()->mutable_radiance(), {0.23, 0.24, 0.27});
}

/// Returns half the width of the framed ellipsoid along a direction.
double half_width(const volume::Header& header, const Framing& framing, Vector along) {
  double squared = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& d = header.direction;
    const double cosine = d[axis] * along.x + d[3 + axis] * along.y + d[6 + axis] * along.z;
    const double reach = framing.half_width[axis] * cosine;
    squared += reach * reach;
  }
  return std::sqrt(squared);
}

/// Where the camera stands: turned from the face to the patient's left, and raised, in degrees.
struct Pose {
  double turned = 25, raised = 10;
};
/// A brain is recognised from the side, and its folds show best from above.
constexpr Pose kBesideBrain{60, 24}, kBesideHead{40, 14};

/// Places the camera for a portrait: a long lens in front of the patient. It is framed on an
/// ellipsoid, since a body rarely fills the corners of a box.
void place_camera(v1::Scene& scene, const volume::Header& header, const Framing& framing,
                  Pose pose) {
  constexpr double kFov = 20, kDegree = std::numbers::pi / 180;
  const double turned = pose.turned * kDegree, raised = pose.raised * kDegree;
  const Vector towards{std::sin(turned) * std::cos(raised), -std::cos(turned) * std::cos(raised),
                       std::sin(raised)};
  const Vector right = unit(cross({0, 0, 1}, towards)), up = cross(towards, right);
  // Pictures are at least as wide as high, except on phones.
  const double half_height =
      kMargin * std::max(half_width(header, framing, up), 0.9 * half_width(header, framing, right));
  // Raises the body above the middle of the picture, whose lower edge the page's controls cover.
  const Vector target = Vector{framing.centre[0], framing.centre[1], framing.centre[2]} +
                        Vector{0, 0, -0.08 * half_height};
  v1::Camera& camera = *scene.mutable_camera();
  set(*camera.mutable_eye(), target + towards * (half_height / std::tan(0.5 * kFov * kDegree)));
  set(*camera.mutable_target(), target);
  set(*camera.mutable_up(), {0, 0, 1});
  camera.set_vertical_fov_degrees(kFov);
}

/// Adds the parts of a scene that do not depend on the materials.
void fill_scene(const volume::Header& header, const Framing& framing, int bounces, double exposure,
                Pose pose, v1::Scene& scene) {
  add_lights(scene, radius_of(framing));
  place_camera(scene, header, framing, pose);
  scene.mutable_phase()->set_g(0);
  scene.mutable_shading()->set_mode(v1::Shading::HYBRID);
  scene.mutable_shading()->set_gradient_scale(kGradientScale);
  scene.set_bounces(bounces);
  v1::Display& display = *scene.mutable_display();
  display.set_curve(v1::Display::FILMIC);
  display.set_exposure(exposure);
  display.set_automatic_exposure(true);
  set(*display.mutable_background(), {0.034, 0.037, 0.043});
  set(*display.mutable_background_edge(), {0.006, 0.007, 0.009});
}

v1::Scene scene_of(const volume::Header& header, const Framing& framing, const Look& look) {
  const bool ct = header.modality == volume::Modality::kCt;
  const auto value_at = [&](double value) { return ct ? value : value_of(header, value); };
  v1::Scene scene;
  scene.mutable_transfer_function()->set_extinction_per_mm(look.extinction_per_mm);
  for (const LookMaterial& material : look.materials) {
    fill_channel(header, material, value_at, *scene.mutable_transfer_function()->add_channels());
  }
  fill_scene(header, framing, look.bounces, look.exposure, {}, scene);
  return scene;
}

/// Returns the brain alone, or within the rest of the head, which becomes like glass.
v1::Preset brain_preset(const volume::Header& header, const Framing& framing,
                        const BrainFacts& brain, bool alone) {
  const double least = header.percentiles[0];
  const auto value_at = [&](double level) { return least + level * (brain.value - least); };
  v1::Preset preset;
  preset.set_name(std::string(alone ? kBrain : kThrough));
  v1::Scene& scene = *preset.mutable_scene();
  v1::TransferFunction& transfer = *scene.mutable_transfer_function();
  transfer.set_extinction_per_mm(alone ? kBrainExtinction : kBrainInGlassExtinction);
  fill_channel(header, {kGreyMatter, kGreyCurve, false}, value_at, *transfer.add_channels());
  fill_channel(header, {kWhiteMatter, kWhiteCurve, true}, value_at, *transfer.add_channels());
  v1::LabelLook& rest = *scene.add_labels();
  rest.set_number(0);
  rest.set_opacity(alone ? 0 : kGlass);
  fill_scene(header, alone ? brain.framing : framing, 3, 0.2, alone ? kBesideBrain : kBesideHead,
             scene);
  return preset;
}

v1::Preset preset_of(const volume::Header& header, const Framing& framing, const Look& look) {
  v1::Preset preset;
  preset.set_name(std::string(look.name));
  *preset.mutable_scene() = scene_of(header, framing, look);
  return preset;
}

bool can_show(const volume::Header& header, std::string_view look, bool contrast_agent) {
  const bool ct = header.modality == volume::Modality::kCt;
  if (look == kVessels) return ct ? contrast_agent : has_bright_vessels(header);
  // A thousandth of a head is a few millilitres, less than its teeth.
  if (look == kDense) return header.percentiles[7] > kHardBone;
  if (look == kAirways && ct) return header.minimum < kInAirways;
  return true;
}

std::span<const Look> looks_for(const volume::Header& header) {
  if (header.modality == volume::Modality::kCt) return kCtLooks;
  return kOtherLooks;
}

}  // namespace

std::vector<v1::Preset> presets_for(const volume::Header& header, const Framing& framing,
                                    bool contrast_agent, const std::optional<BrainFacts>& brain) {
  std::vector<v1::Preset> presets;
  if (brain) {
    presets.push_back(brain_preset(header, framing, *brain, true));
    presets.push_back(brain_preset(header, framing, *brain, false));
  }
  for (const Look& look : looks_for(header)) {
    if (!can_show(header, look.name, contrast_agent)) continue;
    if (brain && look.name == kAirways) continue;
    presets.push_back(preset_of(header, framing, look));
  }
  return presets;
}

Result<v1::Preset> preset_for(const volume::Header& header, const Framing& framing,
                              std::string_view name, const std::optional<BrainFacts>& brain) {
  if (brain && (name == kBrain || name == kThrough)) {
    return brain_preset(header, framing, *brain, name == kBrain);
  }
  const bool ct = header.modality == volume::Modality::kCt;
  if (name == kBrain || (name == kThrough && !ct)) name = kSkinLook;
  for (const Look& look : looks_for(header)) {
    if (look.name == name) return preset_of(header, framing, look);
  }
  return fail(ErrorCode::kNotFound, "there is no preset with this name", "preset");
}

}  // namespace diaphane::render
