#pragma once

#include <cstdint>

namespace diaphane::render {

/// How free flights and transmittances are computed.
enum class Walk : std::uint8_t {
  kAuto,      ///< the fastest to a given error: the exact walk wherever it applies
  kSoonest,   ///< the fastest to a first picture: tracking on the CPU, the same as kAuto on CUDA
  kDraft,     ///< on the CPU, a draft by kSoonest and then a picture by kAuto; on CUDA, kAuto
  kExact,     ///< the exact walk; refused if it does not apply
  kTracking,  ///< delta and residual ratio tracking everywhere: the reference
};

/// Which samples estimate direct light if a direction can be sampled from the light or the matter.
enum class Mis : std::uint8_t {
  kBoth,     ///< both, combined by multiple importance sampling
  kLight,    ///< points on the lights only
  kScatter,  ///< directions sampled from the scattering only
};

/// Options of the estimator. All methods have the same mean and differ in variance and cost. The
/// server uses the three methods below; the others exist for comparison.
struct Method {
  Walk walk = Walk::kAuto;
  bool low_discrepancy = true;  ///< false: independent points (math/points.h)
  Mis mis = Mis::kBoth;
  bool roulette = true;  ///< if false, paths of low weight continue to their last collision

  bool operator==(const Method&) const = default;
};

/// The method for pictures that a user waits for: interactive pictures and thumbnails. On the CPU,
/// a sample by tracking is several times as fast as one by the exact walk, so tracking answers a
/// gesture. The exact walk reaches the same error in a fraction of the time, so it renders pictures
/// at rest. On a GPU, even the exact walk needs only a few milliseconds per sample.
inline constexpr Method kLiveMethod{.walk = Walk::kDraft};
/// The method for pictures and videos in files, which no user sees before they reach their error.
inline constexpr Method kFileMethod{.walk = Walk::kAuto};
/// The method for pictures that several devices render. Their samples are merged with equal
/// weights, so all of them must come from one estimator.
inline constexpr Method kSharedMethod{.walk = Walk::kSoonest};

}  // namespace diaphane::render
