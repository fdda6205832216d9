#pragma once

#include <cstdint>

namespace diaphane::render {

/// How free flights and transmittances are found.
enum class Walk : std::uint8_t {
  kAuto,      ///< what reaches an error first: the exact walk wherever it applies
  kSoonest,   ///< what shows a picture first: on the CPU tracking, on CUDA as kAuto
  kExact,     ///< the exact walk; refused where it does not apply
  kTracking,  ///< delta and residual ratio tracking everywhere: the reference
};

/// Which samples direct light is estimated from, where light and matter can both draw a direction.
enum class Mis : std::uint8_t {
  kBoth,     ///< both, weighted against each other
  kLight,    ///< points on the lights only
  kScatter,  ///< directions in which matter scatters only
};

/// Choices of the estimator. All have the same mean and differ in variance and cost; a server uses
/// kLiveMethod, the others are there to be compared with.
struct Method {
  Walk walk = Walk::kAuto;
  bool low_discrepancy = true;  ///< false: independent points instead (math/points.h)
  Mis mis = Mis::kBoth;
  bool roulette = true;  ///< false: paths of little weight go on to their last collision

  bool operator==(const Method&) const = default;
};

/// For pictures that somebody turns. On the CPU a sample by tracking comes ten times sooner than
/// one by the exact walk, though that needs a fraction of the time to the same error; on a GPU even
/// that one comes within some milliseconds.
inline constexpr Method kLiveMethod{.walk = Walk::kSoonest};

}  // namespace diaphane::render
