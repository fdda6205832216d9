#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include "renderd/math/host_device.h"

namespace diaphane::render {

/// What a scene may need of the kernel, listed once. A variant of the kernel is compiled for a set
/// of features; what is not in the set is not in its code. A variant with more features than a
/// scene needs gives the same estimate (a test holds that), so a general variant can stand in for
/// any other.
enum class Feature : std::uint32_t {
  kRectangles,        ///< at least one rectangle light
  kManyRectangles,    ///< more than one: a light is picked by its power (needs kRectangles)
  kEnvironment,       ///< light from all directions
  kAnisotropicPhase,  ///< Henyey-Greenstein with g other than 0
  kSteepExtinction,   ///< clear and very dense matter side by side: bounds by the voxel
  kCount
};
inline constexpr std::uint32_t kFeatureCount = static_cast<std::uint32_t>(Feature::kCount);
/// For reports; in the order of Feature.
inline constexpr const char* kFeatureNames[kFeatureCount] = {
    "rectangle light", "many rectangle lights", "environment light", "anisotropic phase",
    "steep extinction"};

/// A set of features; structural, so that it can be a template argument.
struct Features {
  std::uint32_t bits = 0;

  HOST_DEVICE constexpr bool has(Feature f) const {
    return (bits >> static_cast<std::uint32_t>(f) & 1u) != 0;
  }
  HOST_DEVICE constexpr Features with(Feature f, bool wanted = true) const {
    return wanted ? Features{bits | 1u << static_cast<std::uint32_t>(f)} : *this;
  }
  constexpr bool operator==(const Features&) const = default;
};
inline constexpr Features kAllFeatures{(1u << kFeatureCount) - 1};
inline constexpr std::uint32_t kVariantCount = 1u << kFeatureCount;

/// The one place where a set of features known at run time becomes compile-time:
/// `make.template operator()<Features>()` gives a variant (a function pointer, say); the table of
/// all of them is indexed by `Features::bits`.
template <typename Variant, typename Make>
struct VariantTable {
  Variant entries[kVariantCount];

  constexpr explicit VariantTable(Make make)
      : VariantTable(make, std::make_index_sequence<kVariantCount>{}) {}
  constexpr Variant operator[](Features f) const { return entries[f.bits]; }

 private:
  template <std::size_t... Bits>
  constexpr VariantTable(Make make, std::index_sequence<Bits...>)
      : entries{make.template operator()<Features{static_cast<std::uint32_t>(Bits)}>()...} {}
};

}  // namespace diaphane::render
