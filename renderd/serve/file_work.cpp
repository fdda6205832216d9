#include "renderd/serve/file_work.h"

#include <algorithm>
#include <utility>

namespace diaphane::render {

FileWork::FileWork(Runner& runner, EncodePool& pool, std::shared_ptr<FrameRenderer> renderer,
                   std::unique_ptr<FileMaker> maker, std::weak_ptr<FileSink> sink,
                   std::function<void(double seconds)> took, FindVolume find)
    : runner_(runner),
      pool_(pool),
      renderer_(std::move(renderer)),
      maker_(std::move(maker)),
      sink_(std::move(sink)),
      took_(std::move(took)),
      find_(std::move(find)) {}

void FileWork::stop() { stopped_ = true; }

void FileWork::next() {
  if (stopped_) return;
  auto step = maker_->next();
  if (!step) {
    auto rest = maker_->finish();
    if (!rest) return fail_with(rest.error());
    put(std::move(*rest), true);
    return send();
  }
  StillJob job;
  job.scene = std::move(step->scene);
  job.canvas = step->canvas;
  job.samples = step->samples;
  job.error = step->error;
  job.smoothed = step->smoothed;
  if (!find_) return submit(std::move(job));
  const auto scene = job.scene;
  find_(*scene, [self = shared_from_this(),
                 job](Result<std::shared_ptr<const DeviceVolume>> volume) mutable {
    if (!volume) return self->fail_with(volume.error());
    job.volume = std::move(*volume);
    self->submit(std::move(job));
  });
}

void FileWork::submit(StillJob job) {
  job.rank = StillRank::kFile;
  job.renderer = renderer_;
  job.took = took_;
  job.cancelled = [self = shared_from_this()] { return self->stopped_.load(); };
  job.done = [self = shared_from_this()](Result<PictureRgb8> picture, double) {
    self->rendered(std::move(picture));
  };
  runner_.submit(std::move(job));
}

void FileWork::rendered(Result<PictureRgb8> picture) {
  if (!picture) return fail_with(picture.error());
  const std::uint64_t samples = renderer_->progress().samples;
  pool_.post(EncodePool::Urgency::kLater, [self = shared_from_this(), picture = std::move(*picture),
                                           samples] { self->code(picture, samples); });
}

void FileWork::code(const PictureRgb8& picture, std::uint64_t samples) {
  if (stopped_) return;
  auto bytes = maker_->take(picture, samples);
  if (!bytes) return fail_with(bytes.error());
  {
    const std::lock_guard one(sending_);
    if (const auto sink = sink_.lock(); sink && !stopped_) sink->progress(maker_->done());
  }
  const bool room = put(std::move(*bytes), false);
  send();
  if (room) next();
}

void FileWork::fail_with(const Error& why) {
  const std::lock_guard one(sending_);
  if (stopped_.exchange(true)) return;
  over_ = true;
  if (const auto sink = sink_.lock()) sink->ended(why);
}

bool FileWork::put(std::string bytes, bool last) {
  const std::lock_guard lock(mutex_);
  ready_.erase(0, std::exchange(cut_, 0));
  if (ready_.empty()) {
    ready_ = std::move(bytes);
  } else {
    ready_ += bytes;
  }
  complete_ = last;
  paused_ = !last && unsent() > kMostUnsentFileBytes;
  return !paused_;
}

void FileWork::taken(std::uint64_t seq) {
  {
    const std::lock_guard lock(mutex_);
    if (seq > sent_) return;  // ignores acknowledgements of parts that were not sent
    taken_ = std::max(taken_, seq);
  }
  send();
  {
    const std::lock_guard lock(mutex_);
    if (!paused_ || unsent() > kMostUnsentFileBytes) return;
    paused_ = false;
  }
  next();
}

void FileWork::send() {
  const std::lock_guard one(sending_);
  const auto sink = sink_.lock();
  while (sink && !stopped_ && !over_) {
    std::string part;
    std::uint64_t seq = 0;
    bool last = false;
    {
      const std::lock_guard lock(mutex_);
      const bool full = sent_ - taken_ >= kFilePartsInFlight;
      if (full || (unsent() < kFilePartBytes && !complete_)) return;
      part = ready_.substr(cut_, kFilePartBytes);
      cut_ += part.size();
      seq = ++sent_;
      last = complete_ && unsent() == 0;
      over_ = last;
    }
    sink->part(seq, std::move(part), last);
  }
}

}  // namespace diaphane::render
