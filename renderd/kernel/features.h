#pragma once

#include <cstdint>

#include "renderd/math/host_device.h"

namespace diaphane::render {

/// What a scene may need of the kernel, listed once. A variant of the kernel is compiled for a set
/// of features; what is not in the set is not in its code. A variant with more features than a
/// scene needs gives the same estimate (a test holds that), so a general variant can stand in for
/// any other.
enum class Feature : std::uint32_t {
  kAreaLights,           ///< at least one light of finite size
  kManyLights,           ///< more than one of them: a light is picked by its power
  kShapedLights,         ///< a disk or a sphere among them
  kTexturedLights,       ///< a texture on one of them
  kEnvironment,          ///< light from all directions
  kTexturedEnvironment,  ///< that differs by direction
  kAnisotropicPhase,     ///< Henyey-Greenstein with g other than 0
  kSurfaces,             ///< scattering at surfaces: gradients are fetched
  kHybrid,               ///< at surfaces or by the phase function, chosen by the gradient
  kGloss,                ///< surfaces with a specular lobe
  kEmission,             ///< matter that glows
  kLens,                 ///< thin lens
  kOrthographic,         ///< parallel camera rays
  kClip,                 ///< box and planes cut camera rays
  kClipLight,            ///< and light
  kSlices,               ///< cross-sections in the picture
  kBounces,              ///< paths of more than one collision
  kSteepExtinction,      ///< clear and very dense matter side by side: bounds by the voxel
  kGuides,               ///< depth, albedo and normal of what is seen, for the denoiser
  kCurves,               ///< an extinction that is not one linear function of the value
  kCount
};
inline constexpr std::uint32_t kFeatureCount = static_cast<std::uint32_t>(Feature::kCount);
/// For reports; in the order of Feature.
inline constexpr const char* kFeatureNames[kFeatureCount] = {
    "area light",        "many lights",
    "shaped lights",     "textured lights",
    "environment",       "textured environment",
    "anisotropic phase", "surfaces",
    "hybrid shading",    "gloss",
    "emission",          "lens",
    "orthographic",      "clip",
    "clipped light",     "slices",
    "bounces",           "steep extinction",
    "denoiser guides",   "curves"};

/// A set of features; structural, so that it can be a template argument.
struct Features {
  std::uint32_t bits = 0;

  HOST_DEVICE constexpr bool has(Feature f) const {
    return (bits >> static_cast<std::uint32_t>(f) & 1u) != 0;
  }
  HOST_DEVICE constexpr Features with(Feature f, bool wanted = true) const {
    return wanted ? Features{bits | 1u << static_cast<std::uint32_t>(f)} : *this;
  }
  HOST_DEVICE constexpr Features without(Feature f) const {
    return Features{bits & ~(1u << static_cast<std::uint32_t>(f))};
  }
  HOST_DEVICE constexpr bool holds(Features other) const { return (other.bits & ~bits) == 0; }
  constexpr bool operator==(const Features&) const = default;
};
inline constexpr Features kAllFeatures{(1u << kFeatureCount) - 1};

}  // namespace diaphane::render
