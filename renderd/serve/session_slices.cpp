#include <utility>

#include "common/log.h"
#include "renderd/encode/slice_codec.h"
#include "renderd/serve/session_turn.h"
#include "renderd/session/kept_voxels.h"
#include "volume/label_slice.h"
#include "volume/second_slice.h"

// LiveSession: reads and encodes the exact slices beside the picture (docs/adr/0026).

namespace diaphane::render {
namespace {

Result<std::vector<std::int16_t>> read_slice(const volume::Volume& volume,
                                             const volume::SliceStack& stack, const SliceDue& due,
                                             const std::optional<v1::Clip>& clip) {
  if (due.curved) {
    if (!clip) return volume::sample(volume, *due.curved);
    return volume::sample_clipped(volume, *due.curved, kept_by(volume.header, *clip));
  }
  if (!clip) {
    return due.oblique ? volume::sample(volume, *due.oblique)
                       : volume::slice_of(volume, stack, due.index);
  }
  const volume::KeptVoxels kept = kept_by(volume.header, *clip);
  return due.oblique ? volume::sample_clipped(volume, *due.oblique, kept)
                     : volume::clipped_slice_of(volume, stack, due.index, kept);
}

/// Returns the values of a second scan at the pixels of a slice with these values.
std::vector<std::int16_t> read_second(const volume::Volume& first, const volume::SliceStack& stack,
                                      const SliceDue& due, const volume::Volume& second,
                                      const volume::Matrix& to_first,
                                      const std::vector<std::int16_t>& values) {
  if (due.curved) return volume::second_slice(first.header, *due.curved, second, to_first, values);
  const auto pixels =
      due.oblique ? volume::pixels_of(*due.oblique) : volume::pixels_of(stack, due.index);
  return volume::second_slice(first.header, pixels, second, to_first, values);
}

/// Returns the encoded labels of a slice with these values, or an empty string.
std::string read_labels(const volume::Volume& volume, const volume::SliceStack& stack,
                        const SliceOrder& order, const std::vector<std::int16_t>& values) {
  if (volume.label_set.empty()) return {};
  const SliceDue& due = order.due;
  const auto labels_of = [&](const volume::ClippedSlice* clipped) {
    if (due.curved) return volume::labels_of_slice(volume, *due.curved, clipped);
    return due.oblique ? volume::labels_of_slice(volume, *due.oblique, clipped)
                       : volume::labels_of_slice(volume, stack, due.index, clipped);
  };
  if (!order.clip) return code_labels(labels_of(nullptr)).value_or("");
  const volume::KeptVoxels kept = kept_by(volume.header, *order.clip);
  const volume::ClippedSlice clipped{kept, values};
  return code_labels(labels_of(&clipped)).value_or("");
}

}  // namespace

void LiveSession::carry_out(const effect::LoadVoxels& effect) {
  // Posted, because the cache may read from the store.
  parts_.slices.pool.post(
      EncodePool::Urgency::kNow, [weak = weak_from_this(), phase = effect.phase] {
        const auto session = weak.lock();
        if (!session) return;
        session->parts_.slices.voxels.get({session->facts_.volume_id, false, phase},
                                          [weak](Result<VolumeCache::Handle> loaded) {
                                            if (const auto alive = weak.lock())
                                              alive->voxels_ready(std::move(loaded));
                                          });
      });
}

void LiveSession::voxels_ready(Result<VolumeCache::Handle> loaded) {
  std::unique_lock lock(mutex_);
  const bool lacks_second = loaded && facts_.second && !second_voxels_;
  lock.unlock();
  if (!lacks_second) return slices_ready(std::move(loaded));
  parts_.slices.voxels.get(
      {facts_.second->volume_id, false, 0},
      [weak = weak_from_this(), first = std::move(loaded)](Result<VolumeCache::Handle> second) {
        const auto alive = weak.lock();
        if (alive) alive->second_voxels_ready(first, second);
      });
}

void LiveSession::second_voxels_ready(const Result<VolumeCache::Handle>& first,
                                      const Result<VolumeCache::Handle>& second) {
  if (!second) {
    // The slices of the first scan are shown without it.
    log::warning("second_slices_failed",
                 {{"session", facts_.id}, {"code", to_string(second.error().code)}});
  } else {
    const std::lock_guard lock(mutex_);
    second_voxels_ = std::dynamic_pointer_cast<const HostVolume>(*second);
  }
  slices_ready(first);
}

void LiveSession::slices_ready(Result<VolumeCache::Handle> loaded) {
  const Turn turn(*this);
  if (ended_) return;
  apply(slices_.handle(VoxelsLoaded{std::move(loaded), volume_->header().content_hash}, state_,
                       turn.now));
}

void LiveSession::carry_out(effect::CodeSlice& effect) {
  const auto urgency =
      effect.for_guest || visitor_ ? EncodePool::Urgency::kLater : EncodePool::Urgency::kNow;
  std::unique_lock lock(mutex_);
  std::shared_ptr<const HostVolume> second = second_voxels_;
  lock.unlock();
  parts_.slices.pool.post(urgency, [weak = weak_from_this(), effect = std::move(effect),
                                    second = std::move(second), facts = facts_.second] {
    if (weak.expired()) return;
    const SliceOrder& order = effect.order;
    const volume::Volume& first = effect.voxels->volume();
    auto values = read_slice(first, effect.stack, order.due, order.clip);
    SliceCoded coded{effect.connection, order, {}};
    if (values && second) {
      coded.second = code_slice(read_second(first, effect.stack, order.due, second->volume(),
                                            facts->to_first, *values))
                         .value_or("");
    }
    if (values && effect.with_labels) {
      coded.labels = read_labels(first, effect.stack, order, *values);
    }
    coded.coded = values.and_then([](const auto& v) { return code_slice(v); });
    if (const auto session = weak.lock()) session->slice_coded(std::move(coded));
  });
}

void LiveSession::slice_coded(SliceCoded coded) {
  const Turn turn(*this);
  apply(slices_.handle(std::move(coded), state_, turn.now));
}

}  // namespace diaphane::render
