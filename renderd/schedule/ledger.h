#pragma once

#include <optional>

#include "renderd/schedule/emission.h"
#include "renderd/schedule/policy.h"
#include "renderd/session/wanted.h"

namespace diaphane::render {

/// What holds for every session of a device.
struct LedgerRules {
  double target_error = 0.01;         ///< relative RMSE at which a picture counts as converged
  std::uint64_t fewest_samples = 16;  ///< below it the error estimate is not trusted to stop
  std::uint64_t most_samples = 1 << 20;
  /// Samples (of pixels) under way at once that keep the device busy; 0: any do.
  double device_parallel = 0;
};

/// What was measured on a device, whoever it was last: what a session starts from.
struct DeviceCosts {
  double seconds_per_pixel = 0;     ///< of one sample; 0: unknown
  double seconds_first = 0;         ///< of a new epoch, beside its samples; 0: unknown
  std::size_t moving_sessions = 0;  ///< at the last look
};

/// A device's account of one session: what is wanted, what its film holds, what was shown of it and
/// what all that cost. Measurements go in, the policy's view comes out; times are arguments, so
/// that the runner keeps it by the clock and the simulator by its own.
class Ledger {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit Ledger(std::uint64_t first_epoch) : epoch_(first_epoch) {}

  /// Takes the newest wish and plans the size of the next picture.
  void refresh(Wanted wanted, const DeviceCosts& device, const LedgerRules& rules, Time now);
  SessionView view(std::uint64_t handle, const DeviceCosts& device, const LedgerRules& rules,
                   Time now) const;
  /// What should_emit is asked; nothing when there is nothing to show.
  std::optional<EmissionQuestion> emission(const LedgerRules& rules, Time now) const;

  /// The film was cleared for what is wanted, which took `seconds`.
  void began(double seconds, Time now);
  /// Neither this scene nor this size is tried again; the picture stays.
  void refused();
  /// A quantum of it ended.
  void rendered(const Batch& batch, const Progress& progress, DeviceCosts& device, Time now);
  /// A picture was handed on; making it took `seconds`.
  void shown(double seconds, DeviceCosts& device, Time now);

  /// The film holds something else than what is wanted.
  bool stale() const {
    return wanted_.scene && (applied_version_ != wanted_.version || planned_ != canvas_);
  }
  bool has_picture() const { return applied_version_.has_value(); }
  bool converged(const LedgerRules& rules) const;
  /// Whether the quantum under way may be cut short for newer input.
  bool interruptible() const;

  const Wanted& wanted() const { return wanted_; }
  Canvas canvas() const { return canvas_; }    ///< of the film
  Canvas planned() const { return planned_; }  ///< of the next
  const Progress& progress() const { return progress_; }
  std::uint64_t epoch() const { return epoch_; }
  std::uint64_t applied_version() const { return applied_version_.value_or(0); }
  std::uint64_t input_seq() const { return input_seq_; }  ///< that the film answers
  std::uint64_t samples_shown() const { return samples_shown_; }
  bool moving() const { return moving_; }
  double scene_seconds() const { return scene_seconds_; }  ///< to make ready what the film holds

 private:
  double seconds_per_pixel(const DeviceCosts& device) const;
  double silence(Time now) const;

  Wanted wanted_;
  bool moving_ = false;
  Canvas planned_;
  Time refreshed_at_{};
  std::uint64_t seen_version_ = 0;
  std::optional<Time> unanswered_since_;

  // What the film holds.
  std::optional<std::uint64_t> applied_version_;
  Canvas canvas_;
  std::optional<Canvas> refused_size_;  // at this version: not tried again
  bool began_moving_ = false;
  Time began_at_{};
  std::uint64_t epoch_ = 0;
  std::uint64_t input_seq_ = 0;
  Progress progress_;
  Time served_at_{};

  // What it costs.
  double seconds_per_pixel_ = 0;
  double noise_ = 0;
  double scene_seconds_ = 0;
  double first_seconds_ = 0;

  // What was shown of it.
  std::uint64_t samples_shown_ = 0;
  bool shown_moving_ = false;
  Time shown_at_{};
};

/// Whether a quantum may be cut short because newer input came: always, but for the first picture
/// of a moving epoch. That one is finished, since input comes faster than a slow device renders,
/// and a picture begun anew with each input would never be shown.
bool may_interrupt(bool began_moving, bool shown);

}  // namespace diaphane::render
