#include "renderd/composite/assist_renderer.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/try.h"
#include "renderd/composite/plan.h"

namespace diaphane::render {
namespace {

/// The runner may still use the scene of two tasks ago when the next task arrives.
constexpr std::size_t kTasksKept = 4;

}  // namespace

void AssistDesk::put(AssistTask task) {
  const std::lock_guard lock(mutex_);
  ++version_;
  tasks_.push_back(std::make_shared<const AssistTask>(std::move(task)));
  if (tasks_.size() > kTasksKept) tasks_.erase(tasks_.begin());
  news_ = {};
  held_ = delivered_ = 0;
  // The part was not sent, so no acknowledgement will come for it.
  if (std::exchange(part_, std::nullopt)) in_transit_ = false;
}

AssistDesk::Order AssistDesk::newest() const {
  const std::lock_guard lock(mutex_);
  return {version_, tasks_.empty() ? nullptr : tasks_.back()};
}

std::shared_ptr<const AssistTask> AssistDesk::of(const diaphane::v1::Scene& scene) const {
  const std::lock_guard lock(mutex_);
  for (const auto& task : tasks_) {
    if (task->scene.get() == &scene) return task;
  }
  return nullptr;
}

void AssistDesk::taken(const AssistNews& news) {
  const std::lock_guard lock(mutex_);
  in_transit_ = false;
  news_ = news;
}

AssistNews AssistDesk::news() const {
  const std::lock_guard lock(mutex_);
  return news_;
}

bool AssistDesk::room() const {
  const std::lock_guard lock(mutex_);
  return !in_transit_;
}

bool AssistDesk::wants_more() const {
  const std::lock_guard lock(mutex_);
  return !tasks_.empty() &&
         may_render({.held = held_, .delivered = delivered_, .room = !in_transit_});
}

void AssistDesk::began(const AssistTask& task) {
  const std::lock_guard lock(mutex_);
  if (tasks_.back().get() == &task) held_ = delivered_ = 0;
}

void AssistDesk::drew(std::uint64_t held) {
  const std::lock_guard lock(mutex_);
  held_ = held;
}

void AssistDesk::hand_over(AssistPart part) {
  const std::lock_guard lock(mutex_);
  held_ = 0;
  delivered_ += part.film.samples;
  in_transit_ = true;
  part_ = std::move(part);
}

std::optional<AssistPart> AssistDesk::collect() {
  const std::lock_guard lock(mutex_);
  return std::exchange(part_, std::nullopt);
}

Result<void> AssistRenderer::set_scene(const diaphane::v1::Scene& scene, Canvas canvas) {
  auto task = desk_->of(scene);
  if (!task || task->canvas != canvas) {
    return fail(ErrorCode::kConflict, "the task no longer exists");
  }
  own_->prepare_denoising(task->guided);
  if (auto set = own_->set_scene(scene, canvas); !set) return set;
  if (auto set = own_->set_share(task->share); !set) return set;
  desk_->began(*task);
  task_ = std::move(task);
  drawn_ = held_ = 0;
  seconds_ = held_seconds_ = 0;
  return {};
}

Result<Batch> AssistRenderer::render(std::uint32_t samples, const std::function<bool()>& stop) {
  // Parts contain pairs of samples.
  auto batch = own_->render(samples + static_cast<std::uint32_t>((held_ + samples) % 2), stop);
  if (!batch) return batch;
  drawn_ += batch->samples;
  held_ += batch->samples;
  seconds_ += batch->seconds;
  held_seconds_ += batch->seconds;
  desk_->drew(held_);
  return batch;
}

Progress AssistRenderer::progress() const {
  const AssistNews news = desk_->news();
  Progress progress;
  progress.samples = drawn_;
  progress.seconds = seconds_;
  progress.error = news.error > 0 ? news.error : std::numeric_limits<double>::infinity();
  return progress;
}

Result<void> AssistRenderer::display(PictureRgb8&) {
  if (!task_ || !desk_->room() || held_ == 0) return {};
  AssistPart part;
  auto taken = own_->take_film(part.film);
  if (taken && !*taken) {
    // An interrupted batch leaves half a pair, or rows with different numbers of samples.
    for (int tries = 0; tries < 2 && taken && !*taken; ++tries) {
      if (auto batch = render(1, [] { return false; }); !batch) {
        return tl::unexpected(batch.error());
      }
      taken = own_->take_film(part.film);
    }
  }
  DIAPHANE_TRY(taken);
  if (!*taken) return {};
  part.epoch = task_->epoch;
  part.sequence = task_->share.sequence;
  part.seconds = held_seconds_;
  held_ = 0;
  held_seconds_ = 0;
  desk_->hand_over(std::move(part));
  return {};
}

}  // namespace diaphane::render
