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

/// Time constant with which recently used device time decays.
constexpr double kLatelySeconds = 1;

/// Applies the viewer's limits. A viewer can choose to stop earlier than the rules say, but not
/// later.
LedgerRules content_with(const Effort& effort, LedgerRules rules) {
  rules.target_error = std::max(rules.target_error, effort.stop_error);
  if (effort.stop_samples > 0) {
    rules.most_samples = std::min(rules.most_samples, effort.stop_samples);
  }
  return rules;
}

/// Returns an exponential moving average with a weight of 0.4 for the new measurement.
double mean(double before, double now) { return before > 0 ? 0.6 * before + 0.4 * now : now; }

}  // namespace

bool may_interrupt(bool began_moving, bool shown) { return shown || !began_moving; }

void Ledger::refresh(ViewRequest requested, const DeviceCosts& device, const LedgerRules& rules,
                     Time now) {
  requested_ = std::move(requested);
  in_gesture_ = !requested_.rest && seconds_between(requested_.last_input, now) < kRestSeconds;
  if (applied_version_ != requested_.version) refused_size_.reset();
  if (requested_.scene && requested_.version != seen_version_) {
    // The input came after the last refresh. A session's first scene came together with the
    // session.
    if (!unanswered_since_) {
      const bool known = refreshed_at_ != Time{};
      unanswered_since_ = known ? std::clamp(requested_.last_input, refreshed_at_, now) : now;
    }
    seen_version_ = requested_.version;
  }
  refreshed_at_ = now;
  // A session that does not gain does not count as waiting.
  const bool gains = requested_.visible && (stale() || !converged(rules));
  if (!gains || served_at_ == Time{}) served_at_ = now;
  const bool answered = applied_version_ == requested_.version;
  preview_ = !in_gesture_ && (answered ? preview_ && samples_shown_ == 0 : needs_preview(device));
  // During a gesture the size changes only with a new scene, so that the current picture keeps
  // converging.
  if (moving() && answered) {
    planned_ = canvas_;
    return;
  }
  planned_ = plan_canvas(
      {.viewport = requested_.viewport,
       .current = canvas_,
       .seconds_per_pixel = seconds_per_pixel(device),
       .seconds_first = first_seconds_ > 0 ? first_seconds_ : device.seconds_first,
       .moving = moving(),
       .sharing = device.moving_sessions,
       .largest_moving = std::min(requested_.moving_scale, requested_.effort.moving_scale)});
  if (refused_size_ == planned_) planned_ = canvas_;
}

// Returns the cost of the session, or that of the last measured session until it is measured.
double Ledger::seconds_per_pixel(const DeviceCosts& device) const {
  return seconds_per_pixel_ > 0 ? seconds_per_pixel_ : device.seconds_per_pixel;
}

bool Ledger::needs_preview(const DeviceCosts& device) const {
  if (requested_.full_size) return false;
  const double cost = seconds_per_pixel(device);
  return cost > 0 ? cost * requested_.viewport.pixels() > kPreviewAboveSeconds
                  : requested_.viewport.pixels() > kProbePixels;
}

bool Ledger::converged(const LedgerRules& device_rules) const {
  const LedgerRules rules = content_with(requested_.effort, device_rules);
  if (progress_.samples >= rules.most_samples) return true;
  return progress_.samples >= rules.fewest_samples && progress_.error <= rules.target_error;
}

bool Ledger::interruptible() const { return may_interrupt(began_moving_, samples_shown_ > 0); }

// Returns the seconds without input. The end of a gesture counts as rest at once, except for its
// preview, which is as urgent as a moving picture.
double Ledger::silence(Time now) const {
  const double seconds = seconds_between(requested_.last_input, now);
  return requested_.rest && !preview_ ? std::max(seconds, kRestSeconds) : seconds;
}

double Ledger::seconds_lately(Time now) const {
  return lately_ * std::exp(-std::max(seconds_between(lately_at_, now), 0.0) / kLatelySeconds);
}

void Ledger::add_to_lately(double seconds, Time now) {
  lately_ = seconds_lately(now) + seconds;
  lately_at_ = now;
}

SessionView Ledger::view(std::uint64_t handle, const DeviceCosts& device,
                         const LedgerRules& device_rules, Time now) const {
  const LedgerRules rules = content_with(requested_.effort, device_rules);
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
  const bool refining = refining_ && !stale();
  view.seconds_per_sample =
      (refining ? refined_seconds_per_pixel_ : seconds_per_pixel(device)) * planned_.pixels();
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
  view.seconds_lately = seconds_lately(now);
  view.seconds_waiting = seconds_between(served_at_, now);
  view.visible = requested_.visible;
  view.wants_frame = requested_.room;
  return view;
}

std::optional<EmissionInput> Ledger::emission(const LedgerRules& rules, Time now) const {
  if (!applied_version_ || !requested_.visible) return std::nullopt;
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
  input.wanted_again = requested_.picture_again && !stale();
  input.room = requested_.room;
  return input;
}

void Ledger::began(double seconds, Time now) {
  applied_version_ = requested_.version;
  canvas_ = planned_;
  began_moving_ = moving();
  began_at_ = now;
  input_seq_ = requested_.input_seq;
  volume_phase_ = requested_.scene->volume_phase();
  progress_ = {};
  progress_.error = kUnknownError;
  samples_shown_ = 0;
  refining_ = false;
  scene_seconds_ = seconds;
  add_to_lately(seconds, now);
  ++epoch_;
}

void Ledger::refused() {
  applied_version_ = requested_.version;
  refused_size_ = planned_;
  planned_ = canvas_;
  unanswered_since_.reset();
}

void Ledger::rendered(const Batch& batch, const Progress& progress, DeviceCosts& device, Time now) {
  progress_ = progress;
  served_at_ = now;
  if (samples_shown_ == 0) add_to_lately(batch.seconds, now);
  if (std::isfinite(progress.error) && progress.samples > 0) {
    noise_ = progress.error * std::sqrt(static_cast<double>(progress.samples));
  }
  if (batch.samples == 0) return;
  const double per_pixel = batch.seconds / (batch.samples * canvas_.pixels());
  refining_ = batch.refined;
  if (refining_) {
    // The size of a moving picture depends on the cost of its first samples alone.
    refined_seconds_per_pixel_ = mean(refined_seconds_per_pixel_, per_pixel);
    return;
  }
  // The first sample of an epoch includes set-up costs, which the moving average soon forgets.
  seconds_per_pixel_ = mean(seconds_per_pixel_, per_pixel);
  device.seconds_per_pixel = seconds_per_pixel_;
}

void Ledger::shown(double seconds, DeviceCosts& device, Time now) {
  if (samples_shown_ == 0) {
    add_to_lately(seconds, now);
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
