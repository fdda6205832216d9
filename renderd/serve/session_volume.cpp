#include <algorithm>
#include <utility>

#include "common/log.h"
#include "renderd/serve/session_turn.h"

// LiveSession: changes to another copy of the volume, such as another phase of the scan, one with
// or without surroundings, or one with new labels.

namespace diaphane::render {

VolumeKey LiveSession::copy_for(const v1::Scene& scene) const {
  return {facts_.volume_id, scene.show_table(), shown_phase(scene, volume_->header())};
}

void LiveSession::make_ready() {
  ready_ = state_.requested;
  ready_.volume = volume_;
}

bool LiveSession::volume_fits() {
  // Before the first volume is there, volume_ready() has not started the runner.
  if (!volume_ || !state_.requested.scene) return true;
  const VolumeKey copy = copy_for(*state_.requested.scene);
  if (copy == copy_) return true;
  if (auto loaded = parts_.volumes.find(copy)) {
    change_volume(copy, std::move(loaded));
    return true;
  }
  // While the renderer still holds an earlier copy, a third one might not fit beside both.
  const bool settled = state_.shown.volume == volume_;
  if (settled && !std::exchange(loading_other_, true)) {
    // The cache may answer at once, which must not happen under the lock.
    parts_.textures.post(EncodePool::Urgency::kLater, [self = shared_from_this(), copy] {
      self->parts_.volumes.get(copy, [self, copy](Result<VolumeCache::Handle> loaded) {
        self->other_volume_ready(copy, std::move(loaded));
      });
    });
  }
  return false;
}

void LiveSession::other_volume_ready(const VolumeKey& copy, Result<VolumeCache::Handle> loaded) {
  show_other_volume(copy, std::move(loaded));
  load_phases();
}

void LiveSession::show_other_volume(const VolumeKey& copy, Result<VolumeCache::Handle> loaded) {
  const Turn turn(*this);
  loading_other_ = false;
  if (ended_) return;
  Outcome outcome;
  const std::shared_ptr<const v1::Scene> scene = state_.requested.scene;
  const bool awaited = scene && copy_for(*scene) == copy;
  if (loaded) {
    change_volume(copy, std::move(*loaded));
    if (scene && !awaited && textures_ready()) {
      // Phases are played faster than they are loaded. The one that was loaded is shown, because
      // otherwise nothing would be until playing stops.
      auto shown = std::make_shared<v1::Scene>(*scene);
      shown->set_volume_phase(copy.phase);
      shown->set_show_table(copy.with_table);
      ++state_.requested.version;
      make_ready();
      ready_.scene = std::move(shown);
    }
    ++state_.requested.version;
  } else if (awaited) {
    outcome = render::refused(state_, state_.requested, loaded.error());
    ++state_.requested.version;
  }
  outcome.wake = true;
  apply_to_presenter(outcome);
}

void LiveSession::labels_changed() {
  VolumeKey copy;
  {
    const Turn turn(*this);
    if (ended_ || !volume_) return;
    copy = copy_;
  }
  parts_.volumes.get(copy, [self = shared_from_this(), copy](Result<VolumeCache::Handle> loaded) {
    self->labels_ready(copy, std::move(loaded));
  });
}

void LiveSession::labels_ready(const VolumeKey& copy, Result<VolumeCache::Handle> loaded) {
  const Turn turn(*this);
  // If the volume changed meanwhile, its new copy has the new labels, too.
  if (ended_ || copy != copy_) return;
  if (!loaded) {
    log::warning("labels_not_shown",
                 {{"session", facts_.id}, {"code", to_string(loaded.error().code)}});
    return;
  }
  change_volume(copy, std::move(*loaded));
  ++state_.requested.version;
  Outcome outcome;
  outcome.wake = true;
  apply_to_presenter(outcome);
}

void LiveSession::change_volume(const VolumeKey& copy, VolumeCache::Handle volume) {
  const std::string labels = volume_ ? volume_->header().label_hash : std::string();
  volume_ = std::move(volume);
  copy_ = copy;
  if (volume_->header().label_hash == labels) return;
  const VolumeStats stats = parts_.stats.of(*volume_);
  for (const Receiver& receiver : state_.audience.receivers) {
    if (receiver.greeted) send_labels(receiver, stats.labels);
  }
  apply(slices_.handle(LabelsReplaced{}, state_));
}

void LiveSession::load_phases() {
  {
    const Turn turn(*this);
    if (ended_ || volume_->header().phase_count() == 1) return;
    report_phases();
    if (!phases_.fit() || std::exchange(loading_phases_, true)) return;
  }
  load_next_phase(volume::kMostPhases);
}

void LiveSession::load_next_phase(std::uint32_t most) {
  VolumeKey next;
  {
    const Turn turn(*this);
    next = report_phases();
    // Other sessions may take the memory meanwhile, so the loads of one round are counted.
    if (ended_ || most == 0 || next == copy_ || !phases_.fit()) {
      loading_phases_ = false;
      return;
    }
  }
  parts_.volumes.get(next, [weak = weak_from_this(), most](Result<VolumeCache::Handle> loaded) {
    const auto self = weak.lock();
    if (!self) return;
    if (loaded) return self->load_next_phase(most - 1);
    // The phases are loaded when they are shown, which reports the error.
    const Turn turn(*self);
    self->loading_phases_ = false;
    self->phases_.set_fit(false);
    self->send_phases_to_all();
  });
}

VolumeKey LiveSession::report_phases() {
  const std::uint32_t phases = volume_->header().phase_count();
  VolumeKey next = copy_;
  std::uint32_t missing = 0;
  for (std::uint32_t ahead = phases; ahead-- > 1;) {
    const VolumeKey copy{copy_.id, copy_.with_table, (copy_.phase + ahead) % phases};
    if (parts_.volumes.find(copy)) continue;
    ++missing;
    next = copy;
  }
  const bool fit = parts_.volumes.fits(copy_.id, phases * volume_->device_bytes());
  if (phases_.loaded() != phases - missing || phases_.fit() != fit) {
    phases_.set_loaded(phases - missing);
    phases_.set_fit(fit);
    send_phases_to_all();
  }
  return next;
}

void LiveSession::send_phases_to_all() {
  for (const Receiver& receiver : state_.audience.receivers) {
    if (receiver.greeted) send_phases(receiver.connection);
  }
}

void LiveSession::send_phases(std::uint64_t connection) {
  v1::ServerMessage message;
  *message.mutable_volume_phases() = phases_;
  send(connection, message);
}

}  // namespace diaphane::render
