#include "renderd/serve/assist_session.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "common/ids.h"
#include "common/try.h"
#include "renderd/composite/composite_engine.h"
#include "renderd/composite/wire.h"
#include "renderd/scene/presets.h"

namespace diaphane::render {
namespace {

/// Size of a band before encoding, which limits how long other calls on the connection wait.
constexpr std::size_t kBandBytes = 1 << 20;
constexpr std::uint32_t kMostParts = 4096;
constexpr std::uint64_t kMostSequences = 1 << 20;

Result<AssistTask> task_of(const v1::AssistTask& message) {
  const Canvas canvas{message.width(), message.height(), message.picture_row(),
                      message.picture_height()};
  if (!is_sound(canvas)) {
    return fail(ErrorCode::kInvalid, "The image size is invalid.", "width");
  }
  const std::uint32_t last = std::min(message.last_row(), message.height());
  if (!is_band(message.first_row(), last, message.height())) {
    return fail(ErrorCode::kInvalid, "The rows do not form a valid band.", "first_row");
  }
  if (message.parts() == 0 || message.parts() > kMostParts || message.part() >= message.parts() ||
      message.sequence() >= kMostSequences) {
    return fail(ErrorCode::kInvalid, "This part of the samples does not exist.", "part");
  }
  DIAPHANE_TRY(check_scene(message.scene()));
  AssistTask task;
  task.epoch = message.epoch();
  task.scene = std::make_shared<const v1::Scene>(message.scene());
  task.canvas = canvas;
  task.share = {message.first_row(), last, message.part(), message.parts(), message.sequence()};
  task.guided = message.guided();
  return task;
}

auto too_many() {
  return fail(ErrorCode::kTooMany, "This worker already assists the maximum number of workers.");
}

}  // namespace

Result<std::shared_ptr<AssistHost::Session>> AssistHost::open(std::shared_ptr<AssistLink> link) {
  const std::lock_guard lock(mutex_);
  if (refusing_) return fail(ErrorCode::kUnavailable, "This worker is shutting down.");
  // Twice as many, because some may be about to end for those that need more than spare time.
  if (sessions_.size() >= 2 * options_.most) return too_many();
  auto session = std::make_shared<Session>(*this, std::move(link));
  sessions_.insert(session);
  return session;
}

Result<void> AssistHost::admit(bool spare) {
  // Sessions count from their connection on.
  if (used() <= options_.most) {
    if (spare && volumes_.bytes() > options_.spare_bytes) {
      return fail(ErrorCode::kTooMany, "This worker has no memory to spare.");
    }
    return {};
  }
  if (!spare && end_spare() && used() <= options_.most) return {};
  return too_many();
}

void AssistHost::forget(const std::shared_ptr<Session>& session) {
  const std::lock_guard lock(mutex_);
  sessions_.erase(session);
}

void AssistHost::end_all() {
  std::set<std::shared_ptr<Session>> ending;
  {
    const std::lock_guard lock(mutex_);
    refusing_ = true;
    ending.swap(sessions_);
  }
  for (const auto& session : ending) {
    session->end({ErrorCode::kUnavailable, "This worker is shutting down.", {}});
  }
}

bool AssistHost::end_spare() {
  std::vector<std::shared_ptr<Session>> ending;
  {
    const std::lock_guard lock(mutex_);
    std::copy_if(sessions_.begin(), sessions_.end(), std::back_inserter(ending),
                 [](const auto& session) { return session->with_spare_time(); });
  }
  for (const auto& session : ending) {
    session->end(
        {ErrorCode::kUnavailable, "This worker has no time or memory to spare any longer.", {}});
  }
  return !ending.empty();
}

std::size_t AssistHost::used() const {
  const std::lock_guard lock(mutex_);
  return sessions_.size();
}

void AssistHost::Session::receive(const v1::AssistRequest& request) {
  Result<void> done =
      fail(ErrorCode::kInvalid, "An Assist stream must start with exactly one open message.");
  switch (request.body_case()) {
    case v1::AssistRequest::kOpen:
      done = open(request.open());
      break;
    case v1::AssistRequest::kTask:
      done = take(request.task());
      break;
    case v1::AssistRequest::kTaken:
      desk_->taken({request.taken().samples(), request.taken().error()});
      home_->runner.wake();
      done = {};
      break;
    case v1::AssistRequest::BODY_NOT_SET:
      break;
  }
  if (!done) end(done.error());
}

Result<void> AssistHost::Session::open(const v1::AssistOpen& open) {
  if (std::exchange(opened_, true)) {
    return fail(ErrorCode::kInvalid, "An Assist stream must start with exactly one open message.");
  }
  if (!is_id(open.volume_id()))
    return fail(ErrorCode::kInvalid, "The volume ID is missing or invalid.", "volume_id");
  DIAPHANE_TRY(host_.admit(open.spare()));
  spare_ = open.spare();
  host_.volumes_.get({open.volume_id(), open.with_table(), open.volume_phase()},
                     [self = shared_from_this(), open](Result<VolumeCache::Handle> volume) {
                       self->volume_ready(open, std::move(volume));
                     });
  return {};
}

void AssistHost::Session::volume_ready(const v1::AssistOpen& open,
                                       Result<VolumeCache::Handle> volume) {
  if (!volume) return end(volume.error());
  auto renderer = renderer_of_one_device(home_->engine, *volume, open.seed(), open.first_sample(),
                                         kSharedMethod);
  if (!renderer) return end(renderer.error());
  const std::lock_guard lock(mutex_);
  if (!link_) return;
  handle_ = home_->runner.add(shared_from_this(),
                              std::make_unique<AssistRenderer>(*std::move(renderer), desk_), 0);
  v1::AssistReply reply;
  reply.mutable_ready();
  link_->send(std::move(reply));
}

Result<void> AssistHost::Session::take(const v1::AssistTask& message) {
  if (!opened_)
    return fail(ErrorCode::kInvalid, "An Assist stream must start with exactly one open message.");
  auto task = task_of(message);
  DIAPHANE_TRY(task);
  desk_->put(std::move(*task));
  version_ = desk_->newest().version;
  home_->runner.wake();
  return {};
}

void AssistHost::Session::closed() {
  std::uint64_t handle = 0;
  {
    const std::lock_guard lock(mutex_);
    link_.reset();
    handle = std::exchange(handle_, 0);
  }
  if (handle != 0) home_->runner.remove(handle);
  host_.forget(shared_from_this());
}

void AssistHost::Session::end(const Error& why) {
  std::shared_ptr<AssistLink> link;
  {
    const std::lock_guard lock(mutex_);
    link = link_;
  }
  // Frees the session's place before the other side learns of the end.
  closed();
  if (link) link->finish(why);
}

ViewRequest AssistHost::Session::requested() {
  ViewRequest requested;
  const AssistDesk::Order order = desk_->newest();
  if (!order.task) return requested;
  requested.version = order.version;
  // Shares the lifetime of the task, because the renderer finds the task by its scene.
  requested.scene = std::shared_ptr<const v1::Scene>(order.task, order.task->scene.get());
  requested.viewport = order.task->canvas;
  requested.input_seq = order.task->epoch;
  requested.rest = true;
  requested.full_size = true;
  requested.raw = true;
  requested.visible = desk_->wants_more();
  requested.room = desk_->room();
  return requested;
}

void AssistHost::Session::send_part() {
  auto part = desk_->collect();
  if (!part) return;
  const double us_per_row = part->seconds * 1e6 / part->film.rows;
  const auto bands = in_bands(std::move(part->film), kBandBytes);
  std::shared_ptr<AssistLink> link;
  {
    const std::lock_guard lock(mutex_);
    link = link_;
  }
  if (!link) return;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const FilmPart& film = bands[i];
    v1::AssistReply reply;
    v1::AssistBand& band = *reply.mutable_band();
    band.set_epoch(part->epoch);
    band.set_sequence(part->sequence);
    band.set_width(film.width);
    band.set_first_row(film.first_row);
    band.set_rows(film.rows);
    band.set_samples(film.samples);
    band.set_render_us(static_cast<std::uint64_t>(us_per_row * film.rows));
    band.set_pixels(pixels_to_wire(film.pixels.data(), film.pixels.size()));
    band.set_guides(guides_to_wire(film.guides));
    band.set_last(i + 1 == bands.size());
    link->send(std::move(reply));
  }
}

}  // namespace diaphane::render
