#include <algorithm>
#include <utility>

#include "common/log.h"
#include "common/try.h"
#include "renderd/serve/session_lane.h"

// LiveSession: pictures through the encoders to the viewers.

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
    out.set_width(data.size.width);
    out.set_height(data.size.height);
    out.set_denoised(frame.denoised);
    out.set_render_us(frame.render_us);
    out.set_encode_us(static_cast<std::uint64_t>(seconds * 1e6));
    out.set_quality(frame.moving ? v1::MOVING : v1::SETTLED);
    out.set_decoder(std::move(data.decoder));
    out.set_data(std::move(data.data));
    for (const OutgoingFrame& outgoing : outgoing_frames.frames) {
      if (outgoing.look) send_look(outgoing.connection);
      out.set_seq(outgoing.seq);
      send_outgoing(outgoing, message);
      parts_.metrics.frame_sent(bytes);
    }
    if (outgoing_frames.input_to_frame) {
      parts_.metrics.input_to_frame(*outgoing_frames.input_to_frame);
    }
  }
  send_tiles();
  parts_.runner.wake();  // the slot is free again
}

void LiveSession::keep_if_last(RenderedPicture& picture) {
  if (!picture.info.converged) return;
  const std::lock_guard lock(mutex_);
  FrameInfo& info = picture.info;
  // A reduced moving picture can converge too, but the final picture has the size of the viewport.
  info.converged = picture.picture.size == state_.shown.viewport;
  if (!info.converged || info.moving) return;  // a resting picture follows in settled quality
  if (last_ && last_->info.epoch == info.epoch && last_->info.samples == info.samples) return;
  const auto& receivers = state_.audience.receivers;
  const bool wanted = std::any_of(receivers.begin(), receivers.end(), [](const Receiver& one) {
    return one.stills != v1::STILL_FORMAT_UNSPECIFIED;
  });
  if (!wanted) return;
  last_ = Last{info, std::make_shared<TileSource>(parts_.encoders, picture.picture,
                                                  [weak = weak_from_this()] {
                                                    if (const auto session = weak.lock())
                                                      session->send_tiles();
                                                  })};
}

void LiveSession::send_tiles() {
  const std::lock_guard lock(mutex_);
  if (!last_) return;
  TileSource& source = *last_->tiles;
  const TimePoint now = parts_.clock.now();
  const auto tiles = static_cast<std::uint32_t>(source.tiles().size());
  for (bool sent = true; sent;) {
    sent = false;
    for (const TileDue& due : tiles_due(state_, last_->info, tiles, now)) {
      const auto coded = source.get(due.tile, due.format);
      // encodes the next tile while this one is in transit
      (void)source.get(due.tile + 1, due.format);
      if (!coded) continue;
      send_tile(due, *coded, depart_tile(state_, due, tiles, coded->data.size(), now));
      sent = true;
    }
  }
}

void LiveSession::send_tile(const TileDue& due, const CodedTile& coded,
                            const OutgoingFrame& outgoing) {
  const auto& tiles = last_->tiles->tiles();
  const Tile& tile = tiles[due.tile];
  v1::ServerMessage message;
  v1::Still& out = *message.mutable_still();
  out.set_epoch(last_->info.epoch);
  out.set_tile(due.tile);
  out.set_tiles(static_cast<std::uint32_t>(tiles.size()));
  out.set_x(tile.x);
  out.set_y(tile.y);
  out.set_width(tile.width);
  out.set_height(tile.height);
  out.set_data(coded.data);
  out.set_hash(coded.hash);
  out.set_format(coded.format);
  out.set_seq(outgoing.seq);
  out.set_iteration(last_->info.samples);
  out.set_error(last_->info.error);
  send_outgoing(outgoing, message);
}

void LiveSession::send_outgoing(const OutgoingFrame& outgoing, const v1::ServerMessage& message) {
  send(outgoing.connection, message);
  if (!outgoing.state) return;
  v1::ServerMessage after;
  *after.mutable_state() = *outgoing.state;
  send(outgoing.connection, after);
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

// An encoder may hold device resources, and without it one picture fewer is encoded.
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
