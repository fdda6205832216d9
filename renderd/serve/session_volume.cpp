#include <utility>

#include "renderd/serve/session_turn.h"

// LiveSession: the volume with or without what surrounds the body.

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
    parts_.runner.replace(runner_handle_, std::move(*renderer));
    volume_ = std::move(*loaded);
    with_table_ = with_table;
  } else if (state_.requested.scene && state_.requested.scene->show_table() == with_table) {
    outcome = render::refused(state_, state_.requested, renderer.error());
    ++state_.requested.version;
  }
  outcome.wake = true;
  apply_to_presenter(outcome);
}

}  // namespace diaphane::render
