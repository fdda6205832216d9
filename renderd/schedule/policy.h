#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace diaphane::render {

/// A session as a policy sees it. Durations are measured by the runner or the simulator, so that a
/// policy needs no clock.
struct SessionView {
  std::uint64_t session = 0;  ///< handle that the runner gave it
  std::uint64_t samples = 0;  ///< per pixel, of this epoch; 0: no sample shows the latest input yet
  double error = 0;           ///< estimated relative RMSE; infinity while unknown
  double target_error = 0;    ///< the picture has converged at or below this error
  /// Error after one sample, estimated from the last picture of the session; 0: unknown.
  double noise = 0;
  double seconds_per_sample = 0;  ///< measured cost of one sample per pixel; 0: unknown
  double seconds_first = 0;  ///< measured cost of a new epoch without its samples (scene, picture)
  double fill = 1;           ///< share of the device that one sample per pixel keeps busy, 0 to 1
  /// Seconds since the last input; at least kRestSeconds if that one ended its gesture.
  double seconds_since_input = 0;
  double seconds_unanswered = 0;   ///< since the oldest input that no frame shows; 0: there is none
  double seconds_since_frame = 0;  ///< since the last frame was handed to the encoder
  double seconds_since_begun = 0;  ///< since the film was last cleared for new input
  /// Device time that its first pictures took recently; it decays to 37% within a second.
  double seconds_lately = 0;
  /// Seconds since its last quantum, or since it began to gain if that was later.
  double seconds_waiting = 0;
  bool visible = true;      ///< a viewer is attached and the picture is on their screen
  bool wants_frame = true;  ///< whether its encoder slot is free and the connection keeps up
  bool spare = false;       ///< rendered only while no other session gains
  bool visitor = false;     ///< belongs to a user without an account (VisitorShare)
  bool under_way = false;   ///< a quantum of it is in flight; this view was taken before that began
};

struct Quantum {
  std::uint64_t session = 0;
  std::uint32_t samples = 1;  ///< per pixel, at least 1
};

/// Decides what is rendered next. The answer depends only on the views and on the policy's own
/// small state, such as the position in a rotation or the number of random draws, but not on the
/// order of the views. The same sequence of calls gets the same answers. A policy uses no clock,
/// GPU, lock or log.
class Policy {
 public:
  virtual ~Policy() = default;
  /// Returns the quanta to begin now, in addition to those in flight: at most one for each session,
  /// only for sessions for which waits() is true, and at least one if there is such a session.
  virtual std::vector<Quantum> next(std::span<const SessionView> sessions) = 0;
  /// Returns quanta to begin although the device is full. They pause the quanta in flight, whose
  /// precedence is at most `highest`. Only the first picture after an input justifies this, and
  /// only if it is due.
  virtual std::vector<Quantum> overtaking(std::span<const SessionView>, unsigned /*highest*/) {
    return {};
  }
};

/// Returns whether another sample would improve a picture that someone sees: it is visible and has
/// not reached its target error.
bool gains(const SessionView& session);

/// Returns whether the session gains and has no quantum in flight.
bool waits(const SessionView& session);

/// Returns the precedence on the CPU of the first picture after an input; everything else has 0. It
/// is 1 if the picture and those before it (`seconds_lately`) take 0.25 s or more, or an unknown
/// time. It rises by one for each factor of four below that, up to kHighestPrecedence. So a small
/// picture does not wait for large ones, and a user with a large window, an expensive scene or many
/// inputs does not slow down others.
unsigned first_picture_precedence(const SessionView& session);
inline constexpr unsigned kHighestPrecedence = 7;

/// Lengths of quanta, as if each had the device to itself. Input of another session does not
/// interrupt a quantum. On a device that queues, the input waits at most for this quantum and the
/// one queued behind it, or for one sample if that takes longer. On other devices its first picture
/// overtakes the quantum (Policy::overtaking).
struct QuantumLimits {
  double quantum_seconds = 0.002;
  /// Length while no session moves: longer quanta have less overhead. The first input of a gesture
  /// may have to wait for two of them.
  double calm_seconds = 0.008;
  /// Length of the first quantum of an epoch. A fast device shows a better first picture at no
  /// noticeable delay.
  double first_seconds = 0.002;
  /// A quantum at most doubles the sample count, because a frame is shown at each doubling. A
  /// quantum may be this long even so, since the launches of shorter ones would cost more than the
  /// frames are worth.
  double least_seconds = 0.001;
  std::uint32_t max_samples = 1024;
};

/// Returns the number of samples that fit into `seconds`: at least one, at most `most`; one if the
/// cost is unknown.
std::uint32_t samples_within(double seconds, double seconds_per_sample, std::uint64_t most);
/// Returns `limits`, with the calm length of a quantum if no visible session has had input
/// recently and none is rendered with spare time, which must delay nobody.
QuantumLimits limits_for(std::span<const SessionView> sessions, const QuantumLimits& limits);
/// Returns the number of samples of a session's next quantum under `limits`.
std::uint32_t quantum_samples(const SessionView& session, const QuantumLimits& limits);

enum class PolicyKind { kMarginalGain, kErrorProportional, kRoundRobin, kFreeForAll };

inline constexpr std::array kPolicyKinds{PolicyKind::kMarginalGain, PolicyKind::kErrorProportional,
                                         PolicyKind::kRoundRobin, PolicyKind::kFreeForAll};

/// Returns "marginal-gain", "error-proportional", "round-robin" or "free-for-all".
std::string_view policy_name(PolicyKind kind);
std::optional<PolicyKind> policy_kind(std::string_view name);
/// Creates a policy. `seed` is for the random draws of PolicyKind::kErrorProportional.
std::unique_ptr<Policy> make_policy(PolicyKind kind, const QuantumLimits& limits = {},
                                    std::uint64_t seed = 1);

}  // namespace diaphane::render
