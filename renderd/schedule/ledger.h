#pragma once

#include <optional>

#include "renderd/schedule/emission.h"
#include "renderd/schedule/policy.h"
#include "renderd/session/view_request.h"

namespace diaphane::render {

/// Rules that apply to every session of a device.
struct LedgerRules {
  double target_error = 0.01;         ///< relative RMSE at which a picture counts as converged
  std::uint64_t fewest_samples = 16;  ///< below this number the error estimate is too unreliable to
                                      ///< stop
  std::uint64_t most_samples = 1 << 20;
  /// Number of pixel samples in flight that keep the device busy; 0: any number does.
  double device_parallel = 0;
};

/// Costs last measured on a device for any session. A new session starts from them.
struct DeviceCosts {
  double seconds_per_pixel = 0;     ///< cost of one sample per pixel; 0: unknown
  double seconds_first = 0;         ///< cost of a new epoch without its samples; 0: unknown
  std::size_t moving_sessions = 0;  ///< as of the last call of Runner::refresh_views()
};

/// Tracks one session on a device: the requested view, the contents of the film, the pictures shown
/// and their costs. It takes measurements and returns the policy's view. Times are arguments, so
/// that the runner passes its clock's time and the simulator its own.
class Ledger {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit Ledger(std::uint64_t first_epoch) : epoch_(first_epoch) {}

  /// Takes the newest request and plans the size of the next picture.
  void refresh(ViewRequest requested, const DeviceCosts& device, const LedgerRules& rules,
               Time now);
  SessionView view(std::uint64_t handle, const DeviceCosts& device, const LedgerRules& rules,
                   Time now) const;
  /// Returns the input of should_emit(), or nullopt if there is no picture to show.
  std::optional<EmissionInput> emission(const LedgerRules& rules, Time now) const;

  /// Records that the film was cleared for the requested view, which took `seconds`.
  void began(double seconds, Time now);
  /// Records that the renderer refused the scene or the size. They are not tried again, and the
  /// picture stays.
  void refused();
  /// Records the end of a quantum.
  void rendered(const Batch& batch, const Progress& progress, DeviceCosts& device, Time now);
  /// Records that a picture was shown; making it took `seconds`.
  void shown(double seconds, DeviceCosts& device, Time now);

  /// Returns whether the film does not hold the requested view.
  bool stale() const {
    return requested_.scene && (applied_version_ != requested_.version || planned_ != canvas_);
  }
  bool has_picture() const { return applied_version_.has_value(); }
  bool converged(const LedgerRules& rules) const;
  /// Returns whether newer input may interrupt the quantum in flight.
  bool interruptible() const;

  const ViewRequest& requested() const { return requested_; }
  Canvas canvas() const { return canvas_; }    ///< size of the film
  Canvas planned() const { return planned_; }  ///< size of the next picture
  const Progress& progress() const { return progress_; }
  std::uint64_t epoch() const { return epoch_; }
  std::uint64_t applied_version() const { return applied_version_.value_or(0); }
  std::uint64_t input_seq() const { return input_seq_; }  ///< newest input that the film shows
  std::uint32_t volume_phase() const { return volume_phase_; }  ///< phase that the film shows
  std::uint64_t samples_shown() const { return samples_shown_; }
  /// Returns whether the next picture is one of a gesture or the preview of a picture at rest:
  /// small, urgent and encoded for speed.
  bool moving() const { return in_gesture_ || preview_; }
  /// Returns the seconds that preparing the film's scene took.
  double scene_seconds() const { return scene_seconds_; }

 private:
  double seconds_per_pixel(const DeviceCosts& device) const;
  double silence(Time now) const;
  double seconds_lately(Time now) const;
  void add_to_lately(double seconds, Time now);
  bool needs_preview(const DeviceCosts& device) const;

  ViewRequest requested_;
  bool in_gesture_ = false;
  bool preview_ = false;
  Canvas planned_;
  Time refreshed_at_{};
  std::uint64_t seen_version_ = 0;
  std::optional<Time> unanswered_since_;

  // Contents of the film.
  std::optional<std::uint64_t> applied_version_;
  Canvas canvas_;
  std::optional<Canvas> refused_size_;  // at this version; not tried again
  bool began_moving_ = false;
  Time began_at_{};
  std::uint64_t epoch_ = 0;
  std::uint64_t input_seq_ = 0;
  std::uint32_t volume_phase_ = 0;
  Progress progress_;
  Time served_at_{};

  // Costs of this session.
  double seconds_per_pixel_ = 0;          // of the first samples of a picture
  double refined_seconds_per_pixel_ = 0;  // of those after a draft (Batch::refined)
  bool refining_ = false;                 // whether the last batch had such samples
  double noise_ = 0;
  double scene_seconds_ = 0;
  double first_seconds_ = 0;
  double lately_ = 0;  // device seconds of first pictures, as of lately_at_
  Time lately_at_{};

  // The last picture that was shown.
  std::uint64_t samples_shown_ = 0;
  bool shown_moving_ = false;
  Time shown_at_{};
};

/// Returns whether newer input may interrupt a quantum. It may always do so, except during the
/// first picture of a moving epoch. Input arrives faster than a slow device renders, so a picture
/// that restarted with each input would never be shown.
bool may_interrupt(bool began_moving, bool shown);

}  // namespace diaphane::render
