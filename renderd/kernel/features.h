#pragma once

#include <cstdint>

#include "renderd/math/host_device.h"

namespace diaphane::render {

/// The features of the kernel that a scene may need. A variant of the kernel is compiled for a set
/// of features and contains no code for others. A variant with more features than a scene needs
/// gives the same estimate (a test checks this), so a general variant can replace any other.
enum class Feature : std::uint32_t {
  kAreaLights,           ///< at least one light of finite size
  kManyLights,           ///< several lights of finite size, sampled in proportion to their power
  kShapedLights,         ///< a light that is a disk or a sphere
  kTexturedLights,       ///< a light of finite size with a texture
  kEnvironment,          ///< light from all directions
  kTexturedEnvironment,  ///< environment light that differs by direction
  kAnisotropicPhase,     ///< Henyey-Greenstein with g other than 0
  kSurfaces,             ///< scattering at surfaces, which needs gradients
  kHybrid,               ///< the gradient decides between surface and phase function
  kGloss,                ///< surfaces with a specular lobe
  kEmission,             ///< matter that glows
  kLens,                 ///< thin lens
  kOrthographic,         ///< parallel camera rays
  kClip,                 ///< a clip box and planes cut camera rays
  kClipLight,            ///< the clip box and planes also cut rays to lights
  kSlices,               ///< cross-sections in the picture
  kBounces,              ///< paths of more than one collision
  kSteepExtinction,      ///< clear and very dense matter side by side, which needs bounds per voxel
  kGuides,               ///< depth, albedo and normal of the visible matter, for the denoiser
  kCurves,               ///< the extinction is not a single linear function of the value
  kLabels,               ///< labels or a highlight change the extinction or the colour of matter
  kOverlay,              ///< a second scan in the same space
  kCount
};
inline constexpr std::uint32_t kFeatureCount = static_cast<std::uint32_t>(Feature::kCount);
/// Names for reports, in the order of Feature.
inline constexpr const char* kFeatureNames[kFeatureCount] = {"area light",
                                                             "many lights",
                                                             "shaped lights",
                                                             "textured lights",
                                                             "environment",
                                                             "textured environment",
                                                             "anisotropic phase",
                                                             "surfaces",
                                                             "hybrid shading",
                                                             "gloss",
                                                             "emission",
                                                             "lens",
                                                             "orthographic",
                                                             "clip",
                                                             "clipped light",
                                                             "slices",
                                                             "bounces",
                                                             "steep extinction",
                                                             "denoiser guides",
                                                             "curves",
                                                             "labels",
                                                             "second scan"};

/// A set of features; structural, so that it can be a template argument.
struct Features {
  std::uint32_t bits = 0;

  HOST_DEVICE constexpr bool has(Feature f) const {
    return (bits >> static_cast<std::uint32_t>(f) & 1u) != 0;
  }
  HOST_DEVICE constexpr Features with(Feature f, bool enabled = true) const {
    return enabled ? Features{bits | 1u << static_cast<std::uint32_t>(f)} : *this;
  }
  HOST_DEVICE constexpr Features without(Feature f) const {
    return Features{bits & ~(1u << static_cast<std::uint32_t>(f))};
  }
  HOST_DEVICE constexpr bool holds(Features other) const { return (other.bits & ~bits) == 0; }
  constexpr bool operator==(const Features&) const = default;
};
inline constexpr Features kAllFeatures{(1u << kFeatureCount) - 1};

}  // namespace diaphane::render
