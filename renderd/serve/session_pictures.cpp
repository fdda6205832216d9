#include <algorithm>
#include <utility>

#include "common/log.h"
#include "common/try.h"
#include "renderd/encode/tiles.h"
#include "renderd/serve/session_lane.h"
#include "renderd/serve/session_turn.h"

// LiveSession: passes pictures through the encoders to the viewers.

namespace diaphane::render {
Admitted LiveSession::admit(const Lane& lane, const FrameInfo& frame) {
  const std::lock_guard lock(mutex_);
  if (!in_use(lane)) return {};
  return render::admit(state_, lane.codec, frame, parts_.clock.now());
}

void LiveSession::coded(const Lane& lane, const FrameInfo& frame, CodedFrame data, double seconds) {
  parts_.metrics.encoded(seconds);
  {
    const std::lock_guard lock(mutex_);
    if (!in_use(lane)) return;
    const std::size_t bytes = data.data.size();
    const OutgoingFrames outgoing_frames =
        depart(state_, lane.codec, frame, {data.key, bytes}, parts_.clock.now());
    v1::ServerMessage message;
    v1::Frame& out = *message.mutable_frame();
    out.set_codec(data.codec);
    out.set_key(data.key);
    out.set_epoch(frame.epoch);
    out.set_input_seq(frame.input_seq);
    out.set_iteration(frame.samples);
    out.set_error(frame.error);
    out.set_stops(frame.stops);
    out.set_width(data.size.width);
    out.set_height(data.size.height);
    out.set_denoised(frame.denoised);
    out.set_volume_phase(frame.volume_phase);
    out.set_render_us(frame.render_us);
    out.set_encode_us(static_cast<std::uint64_t>(seconds * 1e6));
    out.set_quality(frame.moving ? v1::MOVING : v1::SETTLED);
    out.set_decoder(std::move(data.decoder));
    out.set_data(std::move(data.data));
    for (const OutgoingFrame& outgoing : outgoing_frames.frames) {
      if (outgoing.look) send_scene(outgoing.connection);
      out.set_seq(outgoing.seq);
      send(outgoing.connection, message);
      if (outgoing.state) {
        v1::ServerMessage after;
        *after.mutable_state() = *outgoing.state;
        send(outgoing.connection, after);
      }
      parts_.metrics.frame_sent(bytes);
    }
    if (outgoing_frames.input_to_frame) {
      parts_.metrics.input_to_frame(*outgoing_frames.input_to_frame);
    }
  }
  send_tiles();
  parts_.home->runner.wake();  // the encoder has room again
}

void LiveSession::keep_if_last(RenderedPicture& picture) {
  if (!picture.info.converged) return;
  const Turn turn(*this);
  // A reduced moving picture can converge too, but the final picture has the size of the viewport.
  picture.info.converged = picture.picture.size == state_.shown.viewport;
  const auto tiles = static_cast<std::uint32_t>(plan_tiles(picture.picture.size).size());
  apply(tiles_.handle(PictureFinished{picture.info, picture.picture, tiles}, state_));
}

void LiveSession::send_tiles() {
  const Turn turn(*this);
  apply(tiles_.handle(RoomForTiles{}, state_, turn.now));
}

void LiveSession::carry_out(effect::CodeTile& effect) {
  parts_.encoders.post(EncodePool::Urgency::kLater,
                       [weak = weak_from_this(), effect = std::move(effect)] {
                         const auto pixels = effect.pixels.lock();
                         if (!pixels) return;
                         const Tile tile = plan_tiles(pixels->size)[effect.tile];
                         auto coded = encode_tile(*pixels, tile, effect.format);
                         if (!coded)
                           log::error("tile_failed", {{"code", to_string(coded.error().code)}});
                         const auto session = weak.lock();
                         if (!session) return;
                         if (!coded) return session->tile_coded(effect, std::nullopt);
                         v1::Still still;
                         still.set_x(tile.x);
                         still.set_y(tile.y);
                         still.set_width(tile.width);
                         still.set_height(tile.height);
                         still.set_data(std::move(coded->data));
                         still.set_hash(coded->hash);
                         still.set_format(coded->format);
                         session->tile_coded(effect, std::move(still));
                       });
}

void LiveSession::tile_coded(const effect::CodeTile& of, std::optional<v1::Still> coded) {
  const Turn turn(*this);
  apply(tiles_.handle(TileCoded{of.picture, of.tile, std::move(coded)}, state_, turn.now));
}

void LiveSession::dropped(const Lane& lane, const Error& why) {
  log::error("encode_failed", {{"session", facts_.id}, {"code", to_string(why.code)}});
  const std::lock_guard lock(mutex_);
  if (in_use(lane)) release(state_, lane.codec);
}

Result<void> LiveSession::open_lane(v1::Codec codec) {
  for (const auto& lane : lanes_) {
    if (lane->codec == codec) return {};
  }
  auto encoder = make_encoder(codec);
  DIAPHANE_TRY(encoder);
  auto lane = std::make_shared<Lane>(weak_from_this(), codec);
  lane->slot = std::make_shared<EncodeLane>(parts_.encoders, std::move(*encoder), lane);
  lanes_.push_back(std::move(lane));
  return {};
}

// Closes lanes without viewers, because an encoder takes time and may hold device resources.
void LiveSession::close_unused_lanes() {
  std::erase_if(lanes_, [&](const auto& lane) {
    const auto& receivers = state_.audience.receivers;
    const bool used = std::any_of(receivers.begin(), receivers.end(), [&](const Receiver& one) {
      return one.greeted && !one.free_camera && one.codec == lane->codec;
    });
    if (used) return false;
    skipped_before_ += lane->slot->skipped();
    state_.audience.codings.erase(lane->codec);
    return true;
  });
}

bool LiveSession::in_use(const Lane& lane) const {
  return std::any_of(lanes_.begin(), lanes_.end(),
                     [&](const auto& one) { return one.get() == &lane; });
}

}  // namespace diaphane::render
