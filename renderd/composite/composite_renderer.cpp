#include "renderd/composite/composite_renderer.h"

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include "common/try.h"

namespace diaphane::render {
namespace {

using Clock = std::chrono::steady_clock;

/// The division is chosen so that a picture reaches this error soonest.
constexpr double kChosenFor = 0.05;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

double mean(double before, double now) { return before > 0 ? 0.6 * before + 0.4 * now : now; }

bool covers_canvas(const Share& share, Canvas canvas) {
  return share.first_row == 0 && share.last_row >= canvas.height;
}

}  // namespace

CompositeRenderer::CompositeRenderer(std::unique_ptr<FrameRenderer> own,
                                     std::vector<std::unique_ptr<Assistant>> assistants,
                                     CompositeOptions options, std::size_t home)
    : own_(std::move(own)), options_(options), home_(home) {
  for (auto& assistant : assistants) helpers_.emplace_back().assistant = std::move(assistant);
}

void CompositeRenderer::prepare_denoising(bool enabled) {
  guided_ = enabled;
  own_->prepare_denoising(enabled);
}

Result<void> CompositeRenderer::set_volume(std::shared_ptr<const DeviceVolume> volume) {
  auto ours = std::dynamic_pointer_cast<const CompositeVolume>(std::move(volume));
  if (!ours) return fail(ErrorCode::kInternal, "the volume was loaded by another engine");
  DIAPHANE_TRY(own_->set_volume(ours->copy(home_)));
  next_volume_ = std::move(ours);
  return {};
}

Result<void> CompositeRenderer::set_second(std::shared_ptr<const DeviceVolume> volume,
                                           const volume::Matrix& to_first) {
  auto ours = std::dynamic_pointer_cast<const CompositeVolume>(volume);
  if (volume && !ours) {
    return fail(ErrorCode::kInternal, "the volume was loaded by another engine");
  }
  DIAPHANE_TRY(own_->set_second(ours ? ours->copy(home_) : nullptr, to_first));
  has_second_ = ours != nullptr;
  return {};
}

Result<void> CompositeRenderer::set_scene(const diaphane::v1::Scene& scene, Canvas canvas) {
  if (auto taken = own_->set_scene(scene, canvas); !taken) return taken;
  alone_ = has_second_ && scene.overlay().has_transfer_function();
  task_.epoch = ++epoch_;
  task_.scene = std::make_shared<const diaphane::v1::Scene>(scene);
  task_.volume = next_volume_;
  task_.canvas = canvas;
  sequence_ = 0;
  own_share_ = {};
  before_ = report_.assistants > 0 ? std::optional(report_.division) : std::nullopt;
  drawn_.assign((canvas.height + kShareRows - 1) / kShareRows, 0);
  for (Helper& helper : helpers_) {
    helper.silent = false;
    helper.assistant->expect(scene);
  }
  report_ = {};
  return deal(choose());
}

Division CompositeRenderer::choose() const {
  if (alone_) return Division::kAverage;
  if (options_.division) return *options_.division;
  DivisionInput input;
  input.canvas = task_.canvas;
  input.samples = samples_needed_;
  input.speeds.push_back(own_speed_);
  double slowest = 1e12;
  for (const Helper& helper : helpers_) {
    if (helper.assistant->lost()) continue;
    if (helper.assistant->may_pause()) return Division::kAverage;
    input.speeds.push_back(helper.speed);
    slowest = std::min(slowest, helper.assistant->bytes_per_second());
  }
  input.bytes_per_second = slowest;
  input.merge_seconds = std::max(merge_seconds_per_pixel_, kMergeSeconds);
  input.turn_seconds = turn_seconds_;
  input.before = before_;
  return choose_division(input);
}

Result<void> CompositeRenderer::deal(Division division) {
  // A device of unknown speed is assumed to be as fast as the fastest known one.
  double known = own_speed_ > 0 ? own_speed_ : 1;
  for (const Helper& helper : helpers_) known = std::max(known, helper.speed);
  std::vector<double> speeds{own_speed_ > 0 ? own_speed_ : known};
  for (const Helper& helper : helpers_) {
    speeds.push_back(!can_help(helper) ? 0 : helper.speed > 0 ? helper.speed : known);
  }
  const auto shares = plan_shares(division, task_.canvas, speeds, costs_, ++sequence_);
  report_.division = division;
  // For a whole picture, this device records the guides itself.
  task_.guided = guided_ && division == Division::kTiles;
  report_.assistants = 0;
  auto taken = own_->set_share(*shares.front());
  if (!taken && taken.error().code == ErrorCode::kConflict) {
    // An interrupted batch leaves half a pair.
    for (int tries = 0; tries < 2 && !taken; ++tries) {
      const auto batch = own_->render(1, [] { return false; });
      DIAPHANE_TRY(batch);
      learn_own(*batch);
      taken = own_->set_share(*shares.front());
    }
  }
  if (!taken) return taken;
  own_share_ = *shares.front();
  for (std::size_t i = 0; i < helpers_.size(); ++i) {
    Helper& helper = helpers_[i];
    helper.share = shares[i + 1];
    if (!helper.share) continue;
    task_.share = *helper.share;
    helper.assistant->begin(task_);
    ++report_.assistants;
  }
  return {};
}

Result<void> CompositeRenderer::settle_changes() {
  bool joined = false;
  bool left = false;
  for (Helper& helper : helpers_) {
    const bool helps = can_help(helper);
    joined |= helps && !helper.share && !helper.silent;
    left |= !helps && helper.share;
  }
  if (report_.division == Division::kTiles) {
    return joined || left ? deal(Division::kTiles) : Result<void>{};
  }
  for (Helper& helper : helpers_) {
    if (!can_help(helper)) {
      report_.assistants -= helper.share ? 1 : 0;
      helper.share.reset();
    } else if (!helper.share) {
      // The new share gets a new sequence, because those of the other devices are in use.
      helper.share = Share{.sequence = ++sequence_};
      task_.share = *helper.share;
      helper.assistant->begin(task_);
      ++report_.assistants;
    }
  }
  return {};
}

Result<void> CompositeRenderer::merge(Helper& helper, const AssistPart& part) {
  ++report_.parts;
  report_.bytes += part.bytes;
  helped_seconds_ += std::max(part.seconds, 0.0);  // also for parts that come too late
  if (part.epoch != epoch_) {
    ++report_.dropped_parts;
    if (options_.drop_older_epochs) return {};
  }
  if (!fits(part.film, task_.canvas)) return {};  // from an older picture, or malformed
  const auto begin = Clock::now();
  if (auto merged = own_->merge_film(part.film); !merged) return merged;
  const double seconds = seconds_since(begin);
  report_.merge_seconds += seconds;
  const FilmPart& film = part.film;
  const double pixels = double(film.width) * film.rows;
  merge_seconds_per_pixel_ = mean(merge_seconds_per_pixel_, seconds / pixels);
  const std::uint32_t last = film.first_row + film.rows;
  for (std::uint32_t row = film.first_row; row < last; row += kShareRows) {
    drawn_[row / kShareRows] += film.samples;
  }
  // If a part is sent in bands of rows, each band has its share of the seconds.
  if (part.seconds <= 0 || !helper.share || helper.share->sequence != part.sequence) return {};
  const Share& share = *helper.share;
  if (covers_canvas(share, task_.canvas)) {
    helper.speed = mean(helper.speed, pixels * static_cast<double>(film.samples) / part.seconds);
  } else if (helper.speed > 0) {
    const std::uint32_t end = std::min(share.last_row, task_.canvas.height);
    const double rows = end - share.first_row;
    costs_.learn(share.first_row, end, task_.canvas.height,
                 part.seconds / static_cast<double>(film.samples) * rows / film.rows,
                 task_.canvas.pixels() / helper.speed);
  }
  return {};
}

Result<void> CompositeRenderer::absorb() {
  const AssistNews news{*std::min_element(drawn_.begin(), drawn_.end()), told_error_};
  for (Helper& helper : helpers_) {
    while (auto part = helper.assistant->take(news)) {
      if (auto merged = merge(helper, *part); !merged) return merged;
    }
  }
  return {};
}

void CompositeRenderer::learn_own(const Batch& batch) {
  if (batch.samples == 0) return;
  const std::uint32_t last = std::min(own_share_.last_row, task_.canvas.height);
  for (std::uint32_t row = own_share_.first_row; row < last; row += kShareRows) {
    drawn_[row / kShareRows] += batch.samples;
  }
  if (batch.seconds <= 0) return;
  const double per_sample = batch.seconds / batch.samples;
  if (covers_canvas(own_share_, task_.canvas)) {
    own_speed_ = mean(own_speed_, task_.canvas.pixels() / per_sample);
  } else if (own_speed_ > 0) {
    costs_.learn(own_share_.first_row, last, task_.canvas.height, per_sample,
                 task_.canvas.pixels() / own_speed_);
  }
}

bool CompositeRenderer::has_gaps() const {
  return std::find(drawn_.begin(), drawn_.end(), 0U) != drawn_.end();
}

Result<void> CompositeRenderer::await_bands(const std::function<bool()>& stop) {
  const auto begin = Clock::now();
  while (has_gaps()) {
    if (stop && stop()) return {};
    if (auto done = absorb(); !done) return done;
    if (!has_gaps()) return {};
    bool lost = false;
    const bool late = Clock::now() - begin > options_.patience;
    for (Helper& helper : helpers_) {
      if (!helper.share) continue;
      const bool empty = drawn_[helper.share->first_row / kShareRows] == 0;
      if (empty && late) helper.silent = true;
      lost |= !can_help(helper);
    }
    if (lost) {
      // Deals the rows of devices that do not respond to those that do.
      if (auto dealt = deal(Division::kTiles); !dealt) return dealt;
      const auto batch = own_->render(2, stop);
      DIAPHANE_TRY(batch);
      learn_own(*batch);
    } else if (drawn_[own_share_.first_row / kShareRows] < 2) {
      // The other devices render a pair of samples before they deliver their first part, so this
      // one does too.
      const auto batch = own_->render(1, stop);
      DIAPHANE_TRY(batch);
      learn_own(*batch);
      own_extra_ += batch->samples;
    } else {
      std::this_thread::sleep_for(std::chrono::microseconds(300));
    }
  }
  return {};
}

Result<Batch> CompositeRenderer::render(std::uint32_t samples, const std::function<bool()>& stop) {
  if (drawn_.empty()) return own_->render(samples, stop);  // fails because there is no scene
  DIAPHANE_TRY(settle_changes());
  auto batch = own_->render(samples, stop);
  if (!batch) return batch;
  learn_own(*batch);
  const auto begin = Clock::now();
  own_extra_ = 0;
  DIAPHANE_TRY(absorb());
  if (batch->samples > 0) {
    DIAPHANE_TRY(await_bands(stop));
  }
  batch->samples += own_extra_;
  batch->seconds += seconds_since(begin);
  turn_seconds_ = mean(turn_seconds_, batch->seconds);
  batch->helped_seconds = std::exchange(helped_seconds_, 0);
  return batch;
}

Progress CompositeRenderer::progress() const {
  const Progress progress = own_->progress();
  told_error_ = progress.error;
  if (std::isfinite(progress.error) && progress.error > 0) {
    const double off = progress.error / kChosenFor;
    samples_needed_ = std::clamp(static_cast<double>(progress.samples) * off * off, 2.0, 1048576.0);
  }
  return progress;
}

}  // namespace diaphane::render
