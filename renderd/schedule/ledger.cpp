#include "renderd/schedule/ledger.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderd/schedule/canvas.h"

namespace diaphane::render {
namespace {

constexpr double kUnknownError = std::numeric_limits<double>::infinity();

double seconds_between(Ledger::Time from, Ledger::Time to) {
  return std::chrono::duration<double>(to - from).count();
}

/// Applies the viewer's limits. A viewer can choose to stop earlier than the rules say, but not
/// later.
LedgerRules content_with(const Effort& effort, LedgerRules rules) {
  rules.target_error = std::max(rules.target_error, effort.stop_error);
  if (effort.stop_samples > 0) {
    rules.most_samples = std::min(rules.most_samples, effort.stop_samples);
  }
  return rules;
}

/// An exponential moving average with a weight of 0.4 for the new measurement.
double mean(double before, double now) { return before > 0 ? 0.6 * before + 0.4 * now : now; }

}  // namespace

bool may_interrupt(bool began_moving, bool shown) { return shown || !began_moving; }

void Ledger::refresh(ViewRequest wanted, const DeviceCosts& device, const LedgerRules& rules,
                     Time now) {
  wanted_ = std::move(wanted);
  in_gesture_ = !wanted_.rest && seconds_between(wanted_.last_input, now) < kRestSeconds;
  if (applied_version_ != wanted_.version) refused_size_.reset();
  if (wanted_.scene && wanted_.version != seen_version_) {
    // The input came after the last refresh. A session's first scene came together with the
    // session.
    if (!unanswered_since_) {
      const bool known = refreshed_at_ != Time{};
      unanswered_since_ = known ? std::clamp(wanted_.last_input, refreshed_at_, now) : now;
    }
    seen_version_ = wanted_.version;
  }
  refreshed_at_ = now;
  // A session that does not gain does not count as waiting.
  const bool gains = wanted_.visible && (stale() || !converged(rules));
  if (!gains || served_at_ == Time{}) served_at_ = now;
  const bool answered = applied_version_ == wanted_.version;
  preview_ = !in_gesture_ && (answered ? preview_ && samples_shown_ == 0 : needs_preview(device));
  // During a gesture the size changes only with a new scene, so that the current picture keeps
  // converging.
  if (moving() && answered) {
    planned_ = canvas_;
    return;
  }
  planned_ =
      plan_canvas({.viewport = wanted_.viewport,
                   .current = canvas_,
                   .seconds_per_pixel = seconds_per_pixel(device),
                   .seconds_first = first_seconds_ > 0 ? first_seconds_ : device.seconds_first,
                   .moving = moving(),
                   .sharing = device.moving_sessions,
                   .largest_moving = std::min(wanted_.moving_scale, wanted_.effort.moving_scale)});
  if (refused_size_ == planned_) planned_ = canvas_;
}

// Until a session has been measured, it is assumed to cost as much as the last one measured.
double Ledger::seconds_per_pixel(const DeviceCosts& device) const {
  return seconds_per_pixel_ > 0 ? seconds_per_pixel_ : device.seconds_per_pixel;
}

bool Ledger::needs_preview(const DeviceCosts& device) const {
  if (wanted_.full_size) return false;
  const double cost = seconds_per_pixel(device);
  return cost > 0 ? cost * wanted_.viewport.pixels() > kPreviewAboveSeconds
                  : wanted_.viewport.pixels() > kProbePixels;
}

bool Ledger::converged(const LedgerRules& device_rules) const {
  const LedgerRules rules = content_with(wanted_.effort, device_rules);
  if (progress_.samples >= rules.most_samples) return true;
  return progress_.samples >= rules.fewest_samples && progress_.error <= rules.target_error;
}

bool Ledger::interruptible() const { return may_interrupt(began_moving_, samples_shown_ > 0); }

// The end of a gesture means rest at once, without waiting for silence. Only its preview is as
// urgent as a moving picture.
double Ledger::silence(Time now) const {
  const double seconds = seconds_between(wanted_.last_input, now);
  return wanted_.rest && !preview_ ? std::max(seconds, kRestSeconds) : seconds;
}

SessionView Ledger::view(std::uint64_t handle, const DeviceCosts& device,
                         const LedgerRules& device_rules, Time now) const {
  const LedgerRules rules = content_with(wanted_.effort, device_rules);
  SessionView view;
  view.session = handle;
  view.target_error = rules.target_error;
  view.noise = noise_;
  if (stale()) {
    view.error = kUnknownError;
  } else {
    view.samples = progress_.samples;
    // Until the picture has converged, its error is kept above the target, because an estimate from
    // few samples is not reliable.
    view.error = converged(rules) ? 0 : std::max(progress_.error, 2 * rules.target_error);
  }
  view.seconds_per_sample = seconds_per_pixel(device) * planned_.pixels();
  view.seconds_first = first_seconds_ > 0 ? first_seconds_ : device.seconds_first;
  if (rules.device_parallel > 0) {
    view.fill = std::min(1.0, planned_.pixels() / rules.device_parallel);
  }
  view.seconds_since_input = silence(now);
  // A positive minimum, because 0 would mean that no input is unanswered.
  if (unanswered_since_) {
    view.seconds_unanswered = std::max(seconds_between(*unanswered_since_, now), 1e-9);
  }
  view.seconds_since_frame = seconds_between(shown_at_, now);
  view.seconds_since_begun = seconds_between(began_at_, now);
  view.seconds_waiting = seconds_between(served_at_, now);
  view.visible = wanted_.visible;
  view.wants_frame = wanted_.room;
  return view;
}

std::optional<EmissionInput> Ledger::emission(const LedgerRules& rules, Time now) const {
  if (!applied_version_ || !wanted_.visible) return std::nullopt;
  // A picture that is about to be replaced is shown only if none of its epoch has been shown yet.
  if (stale() && samples_shown_ > 0) return std::nullopt;
  EmissionInput input;
  input.samples = progress_.samples;
  input.samples_shown = samples_shown_;
  input.seconds_since_frame = seconds_between(shown_at_, now);
  input.seconds_since_input = silence(now);
  input.moving = moving();
  input.shown_moving = shown_moving_;
  input.converged = converged(rules);
  input.wanted_again = wanted_.picture_again && !stale();
  input.room = wanted_.room;
  return input;
}

void Ledger::began(double seconds, Time now) {
  applied_version_ = wanted_.version;
  canvas_ = planned_;
  began_moving_ = moving();
  began_at_ = now;
  input_seq_ = wanted_.input_seq;
  progress_ = {};
  progress_.error = kUnknownError;
  samples_shown_ = 0;
  scene_seconds_ = seconds;
  ++epoch_;
}

void Ledger::refused() {
  applied_version_ = wanted_.version;
  refused_size_ = planned_;
  planned_ = canvas_;
  unanswered_since_.reset();
}

void Ledger::rendered(const Batch& batch, const Progress& progress, DeviceCosts& device, Time now) {
  progress_ = progress;
  served_at_ = now;
  if (std::isfinite(progress.error) && progress.samples > 0) {
    noise_ = progress.error * std::sqrt(static_cast<double>(progress.samples));
  }
  if (batch.samples == 0) return;
  // The first sample of an epoch includes set-up costs, which the moving average soon forgets.
  seconds_per_pixel_ = mean(seconds_per_pixel_, batch.seconds / (batch.samples * canvas_.pixels()));
  device.seconds_per_pixel = seconds_per_pixel_;
}

void Ledger::shown(double seconds, DeviceCosts& device, Time now) {
  if (samples_shown_ == 0) {
    first_seconds_ = mean(first_seconds_, scene_seconds_ + seconds);
    device.seconds_first = first_seconds_;
    // Input that arrived while this epoch was rendered is answered by the next one.
    if (applied_version_ == seen_version_) {
      unanswered_since_.reset();
    } else {
      unanswered_since_ = began_at_;
    }
  }
  samples_shown_ = progress_.samples;
  shown_moving_ = moving();
  shown_at_ = now;
}

}  // namespace diaphane::render
