#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace diaphane::render::bench {

/// The error that the issue and the thesis's readers call a good picture.
inline constexpr double kGoodError = 0.05;

/// What one session saw, in order of time; seconds of the trace. Both the simulator and the real
/// renderer fill it.
class SessionScore {
 public:
  /// `alone`: seconds from an input to a good picture, had it the device for itself.
  explicit SessionScore(double alone) : alone_(alone) {}

  /// `last`: nobody touches it after that, for now.
  void input(double at, bool last);
  /// Begun on the device: the queueing is over.
  void began(double at);
  /// A picture of the newest input that had been `began` was shown.
  void frame(double at, double error);
  /// The viewer looks away, comes back (what is there is shown), or leaves.
  void hidden(double at);
  void ended(double at);

  /// From a gesture's last input to a good picture, or to the moment when it did not matter any
  /// more: then a lower bound.
  struct ToGood {
    double seconds = 0;
    bool reached = false;
  };
  const std::vector<ToGood>& to_good() const { return to_good_; }
  /// From the oldest input that it answers to each first frame.
  const std::vector<double>& to_first_frame() const { return to_first_; }
  const std::vector<double>& queueing() const { return queueing_; }
  /// The speed seen, of that alone: 1 is all; nothing when no picture was waited for.
  std::optional<double> speed() const;
  std::uint64_t frames() const { return frames_; }

 private:
  void give_up(double at);

  double alone_;
  std::optional<double> waiting_since_;  // the last input of a gesture, no good picture yet
  std::optional<double> oldest_;         // input that is not begun
  std::optional<double> oldest_begun_;   // input that is begun and not shown
  bool last_begun_ = false;              // the film is of the gesture's last input
  bool last_wanted_ = false;
  std::vector<ToGood> to_good_;
  std::vector<double> to_first_;
  std::vector<double> queueing_;
  std::uint64_t frames_ = 0;
};

/// Where the device's time went, seconds.
struct DeviceTime {
  double rendering = 0;
  double scenes = 0;
  double pictures = 0;
  double switching = 0;  ///< between quanta: deciding, launching, waiting for the end of one
  double idle = 0;
  std::uint64_t quanta = 0;
};

/// Of one run of a trace through a policy.
struct Scores {
  double to_good_mean = 0, to_good_p95 = 0;                     ///< seconds
  double first_p50 = 0, first_p95 = 0, first_p99 = 0;           ///< seconds
  double queueing_p50 = 0, queueing_p95 = 0, queueing_p99 = 0;  ///< seconds
  double reached = 0;    ///< share of the pictures waited for that became good in time
  double fairness = 0;   ///< Jain's index of the sessions' speeds
  double idle = 0;       ///< share of the time
  double switching = 0;  ///< share of the time that was not idle
  double rendering = 0, pictures = 0;  ///< as that
  double frames_per_second = 0;        ///< of all sessions
  std::size_t inputs = 0;              ///< pictures waited for
};

Scores score(const std::vector<SessionScore>& sessions, const DeviceTime& time, double seconds);

/// (sum x)^2 / (n sum x^2): 1 when all are equal, 1/n when one has all (Jain, Chiu, Hawe 1984).
double jain(const std::vector<double>& shares);
/// The value below which a share of `at` lies; 0 of nothing.
double quantile(std::vector<double> values, double at);

}  // namespace diaphane::render::bench
