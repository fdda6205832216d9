#pragma once

#include <cstddef>

#include "renderd/kernel/features.h"

namespace diaphane::render {

/// The feature sets for which a kernel is compiled beforehand, from small to large; the last has
/// all features, so there is one for every scene. (CUDA compiles the exact set at run time as
/// well.)
/// A linear function of the value is rare enough to be left to the exact set.
inline constexpr Features kCurved = Features{}.with(Feature::kCurves);
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
    kCurved.with(Feature::kAreaLights)
        .with(Feature::kManyLights)
        .with(Feature::kEnvironment)
        .with(Feature::kSurfaces)
        .with(Feature::kGloss),
    kCurved.with(Feature::kAreaLights)
        .with(Feature::kManyLights)
        .with(Feature::kEnvironment)
        .with(Feature::kGuides),
    kAllFeatures.without(Feature::kGuides),
    kAllFeatures,
};
inline constexpr std::size_t kVariantCount = sizeof(kVariants) / sizeof(kVariants[0]);

/// The first, that is the smallest, of kVariants that has all that is needed.
constexpr std::size_t variant_for(Features needed) {
  std::size_t i = 0;
  while (!kVariants[i].holds(needed)) ++i;
  return i;
}

}  // namespace diaphane::render
