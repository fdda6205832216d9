#include <utility>

#include "common/log.h"
#include "renderd/serve/session_turn.h"

// LiveSession: changes to a copy of the volume with or without surroundings, or with new labels.

namespace diaphane::render {

bool LiveSession::volume_fits() {
  // Before the first volume is there, volume_ready() has not started the runner.
  if (!volume_ || !state_.requested.scene) return true;
  const bool with_table = state_.requested.scene->show_table();
  if (with_table == with_table_) return true;
  if (!std::exchange(loading_other_, true)) {
    // The cache may answer at once, which must not happen under the lock.
    parts_.textures.post(EncodePool::Urgency::kLater, [self = shared_from_this(), with_table] {
      self->parts_.volumes.get({self->facts_.volume_id, with_table},
                               [self, with_table](Result<VolumeCache::Handle> loaded) {
                                 self->other_volume_ready(with_table, std::move(loaded));
                               });
    });
  }
  return false;
}

void LiveSession::other_volume_ready(bool with_table, Result<VolumeCache::Handle> loaded) {
  auto renderer = renderer_of(loaded);
  const Turn turn(*this);
  loading_other_ = false;
  if (ended_) return;
  Outcome outcome;
  if (renderer) {
    change_volume(std::move(*loaded), std::move(*renderer));
    with_table_ = with_table;
  } else if (state_.requested.scene && state_.requested.scene->show_table() == with_table) {
    outcome = render::refused(state_, state_.requested, renderer.error());
    ++state_.requested.version;
  }
  outcome.wake = true;
  apply_to_presenter(outcome);
}

void LiveSession::labels_changed() {
  bool with_table = false;
  {
    const Turn turn(*this);
    if (ended_ || !volume_) return;
    with_table = with_table_;
  }
  parts_.volumes.get({facts_.volume_id, with_table},
                     [self = shared_from_this(), with_table](Result<VolumeCache::Handle> loaded) {
                       self->labels_ready(with_table, std::move(loaded));
                     });
}

void LiveSession::labels_ready(bool with_table, Result<VolumeCache::Handle> loaded) {
  auto renderer = renderer_of(loaded);
  const Turn turn(*this);
  // If the volume changed meanwhile, its new copy has the new labels, too.
  if (ended_ || with_table != with_table_) return;
  if (!renderer) {
    log::warning("labels_not_shown",
                 {{"session", facts_.id}, {"code", to_string(renderer.error().code)}});
    return;
  }
  change_volume(std::move(*loaded), std::move(*renderer));
  ++state_.requested.version;
  Outcome outcome;
  outcome.wake = true;
  apply_to_presenter(outcome);
}

void LiveSession::change_volume(VolumeCache::Handle volume,
                                std::unique_ptr<FrameRenderer> renderer) {
  const std::string labels = volume_ ? volume_->header().label_hash : std::string();
  parts_.home->runner.replace(runner_handle_, std::move(renderer));
  volume_ = std::move(volume);
  if (volume_->header().label_hash == labels) return;
  const VolumeStats stats = parts_.stats.of(*volume_);
  for (const Receiver& receiver : state_.audience.receivers) {
    if (receiver.greeted) send_labels(receiver, stats.labels);
  }
}

}  // namespace diaphane::render
