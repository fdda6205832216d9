#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace diaphane::render::bench {

/// The error of a good picture, according to the readers of the thesis.
inline constexpr double kGoodError = 0.05;

/// What one session saw, in order of time, in seconds of the trace. Filled by both the simulator
/// and the real renderer.
class SessionScore {
 public:
  /// `alone`: seconds from an input to a good picture on a device without other sessions.
  explicit SessionScore(double alone) : alone_(alone) {}

  /// Records an input. `last`: a pause follows it.
  void input(double at, bool last);
  /// Records that rendering began on the device, so queueing is over.
  void began(double at);
  /// Records that a picture of the newest input whose rendering had begun was shown.
  void frame(double at, double error);
  /// Records that the viewer stopped looking at the picture for a while, or left for good
  /// (`ended`).
  void hidden(double at);
  void ended(double at);

  /// Time from the last input of a gesture to a good picture. It is a lower bound if the picture
  /// became irrelevant before.
  struct ToGood {
    double seconds = 0;
    bool reached = false;
  };
  const std::vector<ToGood>& to_good() const { return to_good_; }
  /// Returns the time to each first frame, from the oldest input that it answers.
  const std::vector<double>& to_first_frame() const { return to_first_; }
  const std::vector<double>& queueing() const { return queueing_; }
  /// Returns the speed relative to a device without other sessions, at most 1. Returns nullopt if
  /// no picture was waited for.
  std::optional<double> speed() const;
  std::uint64_t frames() const { return frames_; }

 private:
  void give_up(double at);

  double alone_;
  std::optional<double> waiting_since_;  // last input of a gesture without a good picture yet
  std::optional<double> oldest_;         // input whose rendering has not begun
  std::optional<double> oldest_begun_;   // input whose rendering has begun, but which is not shown
  bool last_begun_ = false;              // the film is of the gesture's last input
  bool last_wanted_ = false;
  std::vector<ToGood> to_good_;
  std::vector<double> to_first_;
  std::vector<double> queueing_;
  std::uint64_t frames_ = 0;
};

/// How the device's time was spent, in seconds.
struct DeviceTime {
  double rendering = 0;
  double scenes = 0;
  double pictures = 0;
  double switching = 0;  ///< between quanta: deciding, launching, and waiting for the end of one
  double idle = 0;
  std::uint64_t quanta = 0;
};

/// Scores of one run of a trace under a policy.
struct Scores {
  double to_good_mean = 0, to_good_p95 = 0;                     ///< seconds
  double first_p50 = 0, first_p95 = 0, first_p99 = 0;           ///< seconds
  double queueing_p50 = 0, queueing_p95 = 0, queueing_p99 = 0;  ///< seconds
  double reached = 0;                  ///< share of awaited pictures that became good in time
  double fairness = 0;                 ///< Jain's index of the sessions' speeds
  double idle = 0;                     ///< share of the time
  double switching = 0;                ///< share of the time that was not idle
  double rendering = 0, pictures = 0;  ///< share of the time that was not idle
  double frames_per_second = 0;        ///< over all sessions
  std::size_t inputs = 0;              ///< number of awaited pictures
};

Scores score(const std::vector<SessionScore>& sessions, const DeviceTime& time, double seconds);

/// Returns (sum x)^2 / (n sum x^2), which is 1 if all are equal and 1/n if one has everything
/// (Jain, Chiu, Hawe 1984).
double jain(const std::vector<double>& shares);
/// Returns the value below which a share of `at` lies, or 0 without values.
double quantile(std::vector<double> values, double at);

}  // namespace diaphane::render::bench
