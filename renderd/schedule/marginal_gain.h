#pragma once

#include "renderd/schedule/policy.h"

namespace diaphane::render {

/// Removes as much error as possible per millisecond of device time, based on measured errors and
/// costs (ADR 0012). It is stateless: the same views always get the same answer.
///
/// 1. Sessions that are due come first, in the order of their deadlines. A first frame is due
///    `deadline_seconds` after the oldest input that it answers, plus the device time that its
///    session's first frames took recently, so that light users come before heavy ones. It has no
///    deadline while its viewer accepts no frame. Any session that gains is due
///    `patience_seconds` after its last quantum. A missed deadline is not moved, so it precedes
///    all later ones and no session starves at any load.
/// 2. Otherwise the session whose next quantum removes the most error per second is chosen. This
///    rate is multiplied by the time for which the picture is expected to stay, because the next
///    input of a drag discards everything rendered since the last one.
/// 3. A moving session whose picture has only just been started yields to other sessions that gain,
///    as long as it can still meet its deadline. If all drags together would take more than
///    `most_drag_share` of the device, they share that part evenly, and what a cheap drag does not
///    need goes to the others (max-min fairness). So expensive drags get fewer frames, and cheap
///    drags still meet their deadlines.
///
/// It returns one quantum at a time; the runner asks again until the device is full. The constants
/// were chosen in the simulator (`./diaphane bench schedule`). Those for drags minimise the time
/// until all 64 sessions have a good picture.
class MarginalGain final : public Policy {
 public:
  struct Options {
    QuantumLimits limits;
    double deadline_seconds = 1.0 / 30;
    /// The patience grows with the number of sessions that gain, so that the quanta given because
    /// it ran out, each of `least_seconds`, take at most `patience_share` of the device.
    double patience_seconds = 2;
    double patience_share = 0.1;
    /// Frames of a moving session are up to `slowest_frame_seconds` apart, so that drags take at
    /// most `drag_share` of the device. Frames of expensive drags are further apart, so that all
    /// drags together take at most `most_drag_share`.
    double slowest_frame_seconds = 0.028;
    double drag_share = 0.7;
    double most_drag_share = 0.8;
    /// A session counts as moving for this long after an input.
    double moving_seconds = 0.15;
    /// A picture below this error is usable. Reaching it counts as removing `usable_worth` more
    /// error. So of several new pictures one after the other becomes usable, which takes half the
    /// mean time of refining all of them together.
    double usable_error = 0.05;
    double usable_worth = 0.2;
    /// The time for which a picture is expected to stay grows by `stay_growth` seconds for each
    /// second without input beyond `silence_seconds`, which is longer than the interval between the
    /// inputs of a drag. It is limited to the range from `shortest_stay` to `longest_stay`,
    /// seconds.
    double silence_seconds = 0.02;
    double stay_growth = 20;
    double shortest_stay = 0.005;
    double longest_stay = 0.3;
  };

  MarginalGain() = default;
  explicit MarginalGain(const Options& options) : options_(options) {}
  std::vector<Quantum> next(std::span<const SessionView> sessions) override;
  std::vector<Quantum> overtaking(std::span<const SessionView> sessions, unsigned highest) override;

  /// Returns the error removed per second, times the expected stay in seconds, as in step 2.
  double gain(const SessionView& session) const;

 private:
  bool may_overtake(const SessionView& session, unsigned above) const;
  /// Returns the quanta to begin. If `above` is set, considers only first pictures that are due,
  /// answer an input and have a precedence above it.
  std::vector<Quantum> choose(std::span<const SessionView> sessions,
                              std::optional<unsigned> above) const;

  Options options_;
};

}  // namespace diaphane::render
