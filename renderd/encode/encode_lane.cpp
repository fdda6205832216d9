#include "renderd/encode/encode_lane.h"

#include <chrono>
#include <utility>

namespace diaphane::render {

EncodeLane::EncodeLane(EncodePool& pool, std::unique_ptr<Encoder> encoder,
                       std::weak_ptr<FrameSink> sink)
    : pool_(pool), encoder_(std::move(encoder)), sink_(std::move(sink)) {}

void EncodeLane::submit(RenderedPicture picture) {
  std::unique_lock lock(mutex_);
  if (slot_) {
    ++skipped_;
    // The replacement of the first picture of an epoch becomes the first, which is still of use
    // after the next epoch has begun.
    if (slot_->info.epoch == picture.info.epoch) {
      picture.info.first_of_epoch = picture.info.first_of_epoch || slot_->info.first_of_epoch;
    }
  }
  slot_ = std::move(picture);
  schedule(lock);
}

void EncodeLane::poke() {
  std::unique_lock lock(mutex_);
  schedule(lock);
}

bool EncodeLane::slot_free() const {
  const std::lock_guard lock(mutex_);
  return !slot_.has_value();
}

std::uint64_t EncodeLane::skipped() const {
  const std::lock_guard lock(mutex_);
  return skipped_;
}

void EncodeLane::schedule(std::unique_lock<std::mutex>& lock) {
  if (scheduled_) {
    poked_ = true;
    return;
  }
  if (!slot_) return;
  scheduled_ = true;
  const bool waited_for = slot_->info.moving || slot_->info.first_of_epoch;
  const std::size_t pixels = slot_->picture.pixels.size() / 3;
  const bool large = pixels > EncodePool::kSmallPixels;
  lock.unlock();
  const std::shared_ptr<FrameSink> sink = sink_.lock();
  const auto now = large ? EncodePool::Urgency::kNowLarge : EncodePool::Urgency::kNow;
  pool_.post(
      waited_for && sink && !sink->gives_way() ? now : EncodePool::Urgency::kLater,
      [self = shared_from_this()] { self->run(); }, pixels);
}

void EncodeLane::run() {
  const std::shared_ptr<FrameSink> sink = sink_.lock();
  std::unique_lock lock(mutex_);
  poked_ = false;
  if (!sink || !slot_) {
    slot_.reset();
    scheduled_ = false;
    return;
  }
  const FrameInfo asked = slot_->info;
  lock.unlock();
  const Admitted admitted = sink->admit(asked);
  lock.lock();
  if (admitted.admission == Admission::kGo) {
    // The slot may hold a newer picture by now, which is sent instead.
    RenderedPicture picture = std::move(*slot_);
    slot_.reset();
    lock.unlock();
    const auto start = std::chrono::steady_clock::now();
    const Quality quality = picture.info.moving ? Quality::kMoving : Quality::kSettled;
    const std::uint32_t most = picture.info.moving ? admitted.moving_bytes : admitted.settled_bytes;
    auto coded = encoder_->encode(picture.picture, {quality, admitted.key, most});
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (coded) {
      sink->coded(picture.info, std::move(*coded), seconds);
    } else {
      sink->dropped(picture.info, coded.error());
    }
    lock.lock();
  } else if (admitted.admission == Admission::kDrop && slot_->info.epoch == asked.epoch &&
             slot_->info.samples == asked.samples) {
    slot_.reset();
    ++skipped_;
  } else if (admitted.admission == Admission::kDrop) {
    poked_ = true;  // a newer picture arrived during the decision about the old one
  }
  scheduled_ = false;
  if (poked_) schedule(lock);
}

}  // namespace diaphane::render
