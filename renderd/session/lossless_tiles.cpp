#include "renderd/session/lossless_tiles.h"

#include <algorithm>

namespace diaphane::render {

Effects LosslessTiles::handle(const PictureFinished& event, const SessionState& state) {
  const FrameInfo& info = event.info;
  if (!info.converged || info.moving) return {};  // a resting picture follows in settled quality
  if (last_ && last_->info.epoch == info.epoch && last_->info.samples == info.samples) return {};
  const auto& receivers = state.audience.receivers;
  const bool needed = std::any_of(receivers.begin(), receivers.end(), [](const Receiver& one) {
    return one.stills != v1::STILL_FORMAT_UNSPECIFIED;
  });
  if (!needed) return {};
  last_ = Last{++pictures_, info, std::make_shared<const PictureRgb8>(event.picture),
               event.tiles, {},   false};
  return {};
}

Effects LosslessTiles::handle(EpochBegan) {
  last_.reset();
  return {};
}

Effects LosslessTiles::handle(TileCoded event, SessionState& state, TimePoint now) {
  if (!last_ || last_->id != event.picture) return {};
  if (!event.coded) {
    last_->failed = true;
    return {};
  }
  const Key key{event.coded->format(), event.tile};
  last_->coded[key] = std::move(event.coded);
  return handle(RoomForTiles{}, state, now);
}

const v1::Still* LosslessTiles::get(const Key& key, Effects& effects) {
  if (key.second >= last_->tiles) return nullptr;
  const auto [found, is_new] = last_->coded.try_emplace(key);
  if (is_new) {
    effects.emplace_back(effect::CodeTile{last_->id, last_->picture, key.second, key.first});
  }
  return found->second ? &*found->second : nullptr;
}

Effects LosslessTiles::handle(RoomForTiles, SessionState& state, TimePoint now) {
  Effects effects;
  if (!last_ || last_->failed) return effects;
  for (bool sent = true; sent;) {
    sent = false;
    for (const TileDue& due : tiles_due(state, last_->info, last_->tiles, now)) {
      const v1::Still* const coded = get({due.format, due.tile}, effects);
      // Encodes the next tile while this one is in transit.
      (void)get({due.format, due.tile + 1}, effects);
      if (!coded) continue;
      OutgoingFrame outgoing = depart_tile(state, due, last_->tiles, coded->data().size(), now);
      effect::Send send{due.connection, {}};
      v1::Still& still = *send.message.mutable_still();
      still = *coded;
      still.set_epoch(last_->info.epoch);
      still.set_tile(due.tile);
      still.set_tiles(last_->tiles);
      still.set_seq(outgoing.seq);
      still.set_iteration(last_->info.samples);
      still.set_error(last_->info.error);
      effects.emplace_back(std::move(send));
      if (outgoing.state) {
        effect::Send after{due.connection, {}};
        *after.message.mutable_state() = *std::move(outgoing.state);
        effects.emplace_back(std::move(after));
      }
      sent = true;
    }
  }
  return effects;
}

}  // namespace diaphane::render
