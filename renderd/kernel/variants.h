#pragma once

#include <cstddef>

#include "renderd/kernel/features.h"

namespace diaphane::render {

/// The feature sets for which a kernel is compiled ahead of time, from small to large. The last set
/// has all features, so each scene has a variant. CUDA also compiles a scene's exact set at run
/// time. An extinction that is a single linear function of the value is rare, so only exact sets
/// omit kCurves.
inline constexpr Features kCurved = Features{}.with(Feature::kCurves);
inline constexpr Features kOneScan = kAllFeatures.without(Feature::kOverlay);
inline constexpr Features kVariants[] = {
    kCurved.with(Feature::kEnvironment),
    kCurved.with(Feature::kAreaLights).with(Feature::kEnvironment),
    kCurved.with(Feature::kAreaLights).with(Feature::kManyLights).with(Feature::kEnvironment),
    kCurved.with(Feature::kAreaLights)
        .with(Feature::kManyLights)
        .with(Feature::kEnvironment)
        .with(Feature::kAnisotropicPhase)
        .with(Feature::kSteepExtinction),
    kCurved.with(Feature::kAreaLights)
        .with(Feature::kManyLights)
        .with(Feature::kEnvironment)
        .with(Feature::kSteepExtinction)
        .with(Feature::kBounces),
    // The built-in looks (renderd/scene/presets.cpp).
    kCurved.with(Feature::kAreaLights)
        .with(Feature::kManyLights)
        .with(Feature::kEnvironment)
        .with(Feature::kSurfaces)
        .with(Feature::kHybrid)
        .with(Feature::kGloss)
        .with(Feature::kSteepExtinction)
        .with(Feature::kBounces),
    kCurved.with(Feature::kAreaLights)
        .with(Feature::kManyLights)
        .with(Feature::kEnvironment)
        .with(Feature::kGuides),
    // Sets with labels and with a second scan come last, so that other scenes use kernels without
    // them.
    kOneScan.without(Feature::kGuides).without(Feature::kLabels),
    kOneScan.without(Feature::kLabels),
    kOneScan.without(Feature::kGuides),
    kOneScan,
    kAllFeatures.without(Feature::kGuides),
    kAllFeatures,
};
inline constexpr std::size_t kVariantCount = sizeof(kVariants) / sizeof(kVariants[0]);

/// Returns the index of the first, and so the smallest, of kVariants that has all needed features.
constexpr std::size_t variant_for(Features needed) {
  std::size_t i = 0;
  while (!kVariants[i].holds(needed)) ++i;
  return i;
}

}  // namespace diaphane::render
