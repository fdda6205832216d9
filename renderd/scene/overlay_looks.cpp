#include "renderd/scene/overlay_looks.h"

#include <algorithm>
#include <array>
#include <string>

#include "renderd/scene/presets.h"

namespace diaphane::render {
namespace {

namespace v1 = diaphane::v1;

/// A step of the colours of hot metal. `level` 0 is the background and 1 the brightest voxels.
struct Heat {
  const char* name;
  double level, opacity;
  std::array<double, 3> colour;
};
/// The first step lies well above the uptake of healthy tissue. Few voxels are much brighter than
/// it, so levels follow the 99th and the 99.9th percentile instead of the maximum.
constexpr std::array<Heat, 4> kHotMetal{{{"warm", 0.30, 0.25, {0.75, 0.06, 0.02}},
                                         {"hot", 0.50, 0.7, {1.00, 0.30, 0.03}},
                                         {"very hot", 0.75, 1.0, {1.00, 0.75, 0.15}},
                                         {"hottest", 1.00, 1.0, {1.00, 0.98, 0.90}}}};
constexpr double kHotExtinction = 0.4;
/// Part of its colour that hot matter emits, so that it is visible in the shadow of other matter.
constexpr double kGlow = 0.6;
/// The colour of a second scan among the colours of skin and bone.
constexpr std::array<double, 3> kTint{0.10, 0.55, 0.95};
constexpr double kTintStrength = 0.75;

void set(v1::Rgb& out, const std::array<double, 3>& colour, double factor = 1) {
  out.set_r(colour[0] * factor);
  out.set_g(colour[1] * factor);
  out.set_b(colour[2] * factor);
}

void add_point(v1::Channel& channel, double value, double opacity) {
  auto& point = *channel.add_opacity();
  point.set_value(value);
  point.set_opacity(opacity);
}

v1::TransferFunction hot_metal(const volume::Header& header) {
  v1::TransferFunction function;
  function.set_extinction_per_mm(kHotExtinction);
  const double low = header.percentiles[3];
  const double high = std::max({header.percentiles[7], low + 1});
  const auto value = [&](double level) { return low + level * (high - low); };
  const double end = std::max<double>(header.maximum, value(1.2)) + 1;
  for (std::size_t i = 0; i < kHotMetal.size(); ++i) {
    v1::Channel& channel = *function.add_channels();
    const Heat& heat = kHotMetal[i];
    channel.set_name(heat.name);
    set(*channel.mutable_diffuse(), heat.colour);
    set(*channel.mutable_emission(), heat.colour, kGlow);
    const double before = i == 0 ? heat.level - 0.1 : kHotMetal[i - 1].level;
    add_point(channel, value(before), 0);
    add_point(channel, value(heat.level), heat.opacity);
    if (i + 1 < kHotMetal.size()) {
      add_point(channel, value(kHotMetal[i + 1].level), 0);
    } else {
      add_point(channel, end, heat.opacity);
    }
  }
  return function;
}

v1::TransferFunction of_preset(const volume::Header& header, const char* name) {
  // Only the materials are used, which do not depend on the framing.
  const Framing framing{.centre = {0, 0, 0}, .half_width = {1, 1, 1}};
  return preset_for(header, framing, name)->scene().transfer_function();
}

v1::TransferFunction tinted(v1::TransferFunction function) {
  for (v1::Channel& channel : *function.mutable_channels()) {
    v1::Rgb& c = *channel.mutable_diffuse();
    const auto mix = [](double own, double tint) { return own + (tint - own) * kTintStrength; };
    c.set_r(mix(c.r(), kTint[0]));
    c.set_g(mix(c.g(), kTint[1]));
    c.set_b(mix(c.b(), kTint[2]));
  }
  return function;
}

v1::OverlayLook look(const char* name, v1::TransferFunction function, double share) {
  v1::OverlayLook look;
  look.set_name(name);
  v1::Overlay& overlay = *look.mutable_overlay();
  *overlay.mutable_transfer_function() = std::move(function);
  overlay.set_share(share);
  overlay.set_split(0.5);
  return look;
}

}  // namespace

std::vector<v1::OverlayLook> overlay_looks(const volume::Header& first,
                                           const volume::Header& second) {
  // What lies inside the first scan is visible only if that gives way.
  constexpr double kInside = 0.75, kBoth = 0.5;
  std::vector<v1::OverlayLook> looks;
  const bool pet = second.modality == volume::Modality::kPt;
  if (pet) looks.push_back(look("hot", hot_metal(second), kInside));
  if (second.modality == volume::Modality::kCt && first.modality != volume::Modality::kCt) {
    looks.push_back(look("bone", of_preset(second, "bone"), kInside));
  }
  const v1::TransferFunction own = of_preset(second, "skin");
  looks.push_back(look("tint", tinted(own), kBoth));
  looks.push_back(look("same", own, kBoth));
  if (second.modality == volume::Modality::kCt && first.modality == volume::Modality::kCt) {
    looks.push_back(look("bone", of_preset(second, "bone"), kInside));
  }
  // SPECT, perfusion and files of research formats do not say what their values are.
  if (!pet && second.modality != volume::Modality::kCt) {
    looks.push_back(look("hot", hot_metal(second), kInside));
  }
  return looks;
}

}  // namespace diaphane::render
