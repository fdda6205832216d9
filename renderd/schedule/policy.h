#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace diaphane::render {

/// What is known of a session when the next quanta are decided. Plain data; times are durations
/// that the runner (or the simulator) measured, so that a policy needs no clock.
struct SessionView {
  std::uint64_t session = 0;  ///< the runner's handle
  std::uint64_t samples = 0;  ///< per pixel, of this epoch; 0: input waits that no sample shows
  double error = 0;           ///< estimated relative RMSE; infinity while unknown
  double target_error = 0;    ///< converged at or below
  double noise = 0;           ///< error of one sample, by this session's last picture; 0: unknown
  double seconds_per_sample = 0;  ///< measured cost of one sample per pixel; 0: unknown
  double seconds_first = 0;  ///< measured cost of a new epoch beside its samples (scene, picture)
  double fill = 1;           ///< share of the device that one sample per pixel keeps busy, 0 to 1
  double seconds_since_input = 0;  ///< long, when the last one ended its gesture
  double seconds_unanswered = 0;   ///< since the oldest input that no frame shows; 0: none waits
  double seconds_since_frame = 0;  ///< since the last frame was handed to the encoder
  double seconds_since_begun = 0;  ///< since the film was last cleared for new input
  double seconds_waiting = 0;      ///< since its last quantum, or since it began to gain
  bool visible = true;             ///< a viewer is attached and looks
  bool wants_frame = true;         ///< its encoder slot is free and the client has room
  bool visitor = false;            ///< of somebody without an account (VisitorShare)
  bool under_way = false;          ///< a quantum of it is on the device; the view is from before it
};

struct Quantum {
  std::uint64_t session = 0;
  std::uint32_t samples = 1;  ///< per pixel, at least 1
};

/// Decides what is rendered next: a pure function of the views and of its own small state (a turn,
/// a count of draws). No clock, no GPU, no lock, no log. The order of the views is of no meaning,
/// and the same questions get the same answers.
class Policy {
 public:
  virtual ~Policy() = default;
  /// The quanta that go to the device now, beside those under way: of each session at most one,
  /// none of one that `waits` not, and at least one while some session does.
  virtual std::vector<Quantum> next(std::span<const SessionView> sessions) = 0;
};

/// True while another sample changes what somebody sees: visible and not yet at the target error.
bool gains(const SessionView& session);

/// Gains, and nothing of it is under way.
bool waits(const SessionView& session);

/// How long a quantum is, had it the device for itself. It is never cut short for another session's
/// input: an input waits at most for it and for the one behind it, or a sample where that is
/// longer.
struct QuantumLimits {
  double quantum_seconds = 0.002;
  /// While nobody moves: fewer of them, with less between them. The first input of a gesture may
  /// wait for two of these.
  double calm_seconds = 0.008;
  /// Of the first of an epoch: a fast device shows a better picture before anybody notices.
  double first_seconds = 0.002;
  /// Doublings of the sample count are not jumped over (a frame is shown at each), but for quanta
  /// shorter than this: those would cost more in launches than they bring.
  double least_seconds = 0.001;
  std::uint32_t max_samples = 1024;
};

/// As many samples as fit `seconds`, at least one, at most `most`; one while the cost is unknown.
std::uint32_t samples_within(double seconds, double seconds_per_sample, std::uint64_t most);
/// `limits` where nobody has moved for a moment: calm ones.
QuantumLimits limits_for(std::span<const SessionView> sessions, const QuantumLimits& limits);
/// The samples of a session's next quantum under `limits`.
std::uint32_t quantum_samples(const SessionView& session, const QuantumLimits& limits);

enum class PolicyKind { kMarginalGain, kErrorProportional, kRoundRobin, kFreeForAll };

inline constexpr std::array kPolicyKinds{PolicyKind::kMarginalGain, PolicyKind::kErrorProportional,
                                         PolicyKind::kRoundRobin, PolicyKind::kFreeForAll};

/// "marginal-gain", "error-proportional", "round-robin", "free-for-all".
std::string_view policy_name(PolicyKind kind);
std::optional<PolicyKind> policy_kind(std::string_view name);
/// `seed` is of the draws, for the policy that has any.
std::unique_ptr<Policy> make_policy(PolicyKind kind, const QuantumLimits& limits = {},
                                    std::uint64_t seed = 1);

}  // namespace diaphane::render
