#include "renderd/serve/live_session.h"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <random>
#include <set>

#include "common/log.h"
#include "renderd/encode/frame_mark.h"
#include "renderd/scene/presets.h"
#include "volume/header.h"

namespace diaphane::render {
namespace {

// Epochs of a session placed again begin above those of the worker before, so that no frame of the
// old one can pass for a new one.
std::uint64_t first_epoch(std::uint64_t placement) { return placement << 24; }

v1::VolumeHeader to_proto(const volume::Header& header) {
  v1::VolumeHeader message;
  // The JSON form is the one description of the header; this is done once a connection.
  if (const auto json = volume::to_json(header)) {
    (void)google::protobuf::util::JsonStringToMessage(*json, &message);
  }
  return message;
}

std::uint64_t random_seed() {
  std::random_device device;
  return (std::uint64_t{device()} << 32) | device();
}

}  // namespace

// Keeps the encoder's questions apart: which codec is asked for, and whether it is still in use.
class LiveSession::Lane final : public FrameSink {
 public:
  Lane(std::weak_ptr<LiveSession> session, v1::Codec for_codec)
      : codec(for_codec), session_(std::move(session)) {}

  Admitted admit(const FrameInfo& frame) override {
    const auto session = session_.lock();
    return session ? session->admit(*this, frame) : Admitted{};
  }
  void coded(const FrameInfo& frame, Canvas size, CodedFrame data, double seconds) override {
    if (const auto session = session_.lock()) {
      session->coded(*this, frame, size, std::move(data), seconds);
    }
  }
  void dropped(const FrameInfo&, const Error& why) override {
    if (const auto session = session_.lock()) session->dropped(*this, why);
  }

  const v1::Codec codec;
  std::shared_ptr<EncodeLane> slot;  // set once, before anybody else sees the lane

 private:
  const std::weak_ptr<LiveSession> session_;
};

LiveSession::LiveSession(SessionParts parts, Start start, std::function<void(const Error&)> ended)
    : parts_(std::move(parts)),
      id_(start.id),
      volume_id_(start.volume_id),
      user_id_(std::move(start.user_id)),
      on_ended_(std::move(ended)) {
  state_.id = std::move(start.id);
  state_.volume_id = std::move(start.volume_id);
  state_.placement = start.placement;
  state_.wanted.scene = std::move(start.scene);
  state_.wanted.viewport = start.viewport;
  state_.wanted.input_seq = start.input_seq;
  state_.wanted.version = 1;
  state_.camera_only = start.camera_only;
  if (!start.presenter.empty()) state_.audience.presenter = std::move(start.presenter);
  state_.codecs.clear();
  for (const v1::Codec codec : {v1::H264, v1::JPEG, v1::MPEG1}) {
    if (can_encode(codec)) state_.codecs.push_back(codec);
  }
  version_ = 1;
  stats_since_ = parts_.clock.now();
  state_.detached_since = stats_since_;
  state_.audience.presenter_left = stats_since_;
}

Result<std::uint64_t> LiveSession::attach(std::shared_ptr<ClientLink> link, const Arrival& arrival,
                                          std::uint64_t placement) {
  const std::lock_guard lock(mutex_);
  const auto attached = render::attach(state_, arrival, parts_.clock.now());
  if (!attached) return tl::unexpected(attached.error());
  if (attached->replaced) {
    finish_link(*attached->replaced,
                {ErrorCode::kConflict, "This session was opened in another window.", {}}, true);
  }
  links_.emplace(attached->connection, std::move(link));
  state_.placement = placement;
  return attached->connection;
}

void LiveSession::volume_ready(Result<std::shared_ptr<const DeviceVolume>> volume) {
  Result<std::unique_ptr<FrameRenderer>> renderer = fail(ErrorCode::kInternal, "");
  if (volume) renderer = parts_.engine.renderer(*volume, random_seed(), 0, kLiveMethod);
  if (!volume || !renderer) return failed(!volume ? volume.error() : renderer.error());
  std::vector<v1::Preset> presets = presets_for((*volume)->header());
  if (presets.empty()) {
    return failed({ErrorCode::kUnsupported, "There is no way to show this kind of volume.", {}});
  }

  const std::lock_guard lock(mutex_);
  if (ended_) return;
  volume_ = std::move(*volume);
  presets_ = std::move(presets);
  // A scene that an older program wrote may be refused by this one: better another look than none.
  if (state_.wanted.scene && !check_scene(*state_.wanted.scene)) state_.wanted.scene.reset();
  if (!state_.wanted.scene) {
    state_.wanted.scene = std::make_shared<const v1::Scene>(presets_.front().scene());
  }
  runner_handle_ =
      parts_.runner.add(shared_from_this(), std::move(*renderer), first_epoch(state_.placement));
  for (const Receiver& receiver : state_.audience.receivers) {
    if (receiver.greeted) send_config(receiver.connection);
  }
  tell_audience();
}

void LiveSession::receive(std::uint64_t connection, const std::string& bytes) {
  v1::ClientMessage message;
  const bool sound = message.ParseFromString(bytes);
  std::unique_lock lock(mutex_);
  if (!links_.contains(connection)) return;
  if (!sound) {
    finish_link(connection,
                {ErrorCode::kInvalid, "The page sent something that is no message.", {}}, true);
    return leave(connection);
  }
  if (const auto own = branches_.find(connection); own != branches_.end()) {
    // What concerns the pictures is said to the session that he looks at.
    if (message.has_scene() || message.has_ack() || message.has_need_key() ||
        message.has_visibility()) {
      const OwnCamera camera = own->second;
      lock.unlock();
      return camera.session->receive(camera.connection, bytes);
    }
  }
  const Outcome outcome = render::receive(state_, connection, message, parts_.clock.now());
  carry_out(outcome, connection, lock);
  if (outcome.own_camera) change_camera(connection, *outcome.own_camera);
}

void LiveSession::closed(std::uint64_t connection) {
  std::shared_ptr<LiveSession> branch;
  {
    const std::lock_guard lock(mutex_);
    branch = take_branch(connection);
    if (links_.erase(connection) != 0) leave(connection);
  }
  if (branch) branch->dismiss();
  parts_.runner.wake();
}

void LiveSession::end(const Error& why) {
  std::uint64_t handle = 0;
  std::vector<std::shared_ptr<LiveSession>> branches;
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return;
    ended_ = true;
    while (!branches_.empty()) branches.push_back(take_branch(branches_.begin()->first));
    while (!links_.empty()) finish_link(links_.begin()->first, why, true);
    handle = std::exchange(runner_handle_, 0);
  }
  for (const auto& branch : branches) branch->dismiss();
  if (handle != 0) parts_.runner.remove(handle);
}

void LiveSession::tick() {
  Lanes poked;
  {
    const std::lock_guard lock(mutex_);
    const TimePoint now = parts_.clock.now();
    for (const std::uint64_t silent : overdue_greetings(state_, now)) {
      finish_link(silent, {ErrorCode::kInvalid, "The page did not say anything.", {}}, true);
      leave(silent);
    }
    poked = lanes_;
    const double seconds = std::chrono::duration<double>(now - stats_since_).count();
    if (seconds >= 1) {
      std::uint64_t skipped = skipped_before_;
      for (const auto& lane : lanes_) skipped += lane->slot->skipped();
      parts_.metrics.frames_skipped(skipped - skipped_told_);
      skipped_told_ = skipped;
      if (samples_since_ > 0) {
        v1::ServerMessage message;
        v1::Stats& stats = *message.mutable_stats();
        stats.set_samples_per_second(static_cast<double>(samples_since_) / seconds);
        stats.set_sessions(static_cast<std::uint32_t>(parts_.session_count()));
        stats.set_dropped_samples(dropped_samples_);
        stats.set_frames_skipped(skipped);
        for (const Receiver& receiver : state_.audience.receivers) {
          if (is_watching(receiver, now)) send(receiver.connection, message);
        }
      }
      stats_since_ = now;
      samples_since_ = 0;
    }
  }
  // One that sets the pace may have stalled, and a key frame may be due, without anybody's word.
  for (const auto& lane : poked) lane->slot->poke();
  send_tiles();
}

std::uint64_t LiveSession::placement() const {
  const std::lock_guard lock(mutex_);
  return state_.placement;
}

std::optional<std::chrono::steady_clock::duration> LiveSession::abandoned_for() const {
  const std::lock_guard lock(mutex_);
  if (!state_.audience.receivers.empty()) return std::nullopt;
  return parts_.clock.now() - state_.detached_since;
}

LiveSession::Saved LiveSession::saved() const {
  return Saved{id_,
               state_.placement,
               state_.wanted.scene->SerializeAsString(),
               state_.wanted.input_seq,
               state_.wanted.viewport,
               state_.audience.presenter};
}

std::optional<LiveSession::Saved> LiveSession::take_unsaved() {
  const std::lock_guard lock(mutex_);
  if (!state_.unsaved || !state_.wanted.scene) return std::nullopt;
  state_.unsaved = false;
  return saved();
}

std::optional<LiveSession::Lost> LiveSession::lost() const {
  const std::lock_guard lock(mutex_);
  if (ended_ || !state_.wanted.scene || user_id_.empty()) return std::nullopt;
  std::set<std::string> links;
  for (const Receiver& receiver : state_.audience.receivers) {
    if (!receiver.link.empty()) links.insert(receiver.link);
  }
  return Lost{saved(), user_id_, volume_id_, {links.begin(), links.end()}};
}

void LiveSession::mark_unsaved() {
  const std::lock_guard lock(mutex_);
  state_.unsaved = true;
}

Wanted LiveSession::wanted() {
  const std::lock_guard lock(mutex_);
  const TimePoint now = parts_.clock.now();
  Wanted wanted = state_.wanted;
  wanted.visible = watched(state_, now);
  wanted.room = std::any_of(lanes_.begin(), lanes_.end(), [&](const auto& lane) {
    return lane->slot->slot_free() && has_room(state_, lane->codec, now);
  });
  // A hidden viewer keeps its wish until it looks again.
  if (wanted.visible) state_.wanted.picture_again = false;
  return wanted;
}

std::uint64_t LiveSession::version() const noexcept {
  return version_.load(std::memory_order_relaxed);
}

void LiveSession::began(std::uint64_t epoch, const Wanted& wanted) {
  const std::lock_guard lock(mutex_);
  render::began(state_, epoch, wanted);
  last_.reset();
}

void LiveSession::refused(const Wanted& wanted, const Error& why) {
  std::unique_lock lock(mutex_);
  const Outcome outcome = render::refused(state_, wanted, why);
  const Receiver* presenter = state_.audience.of(state_.audience.presenter);
  carry_out(outcome, presenter ? presenter->connection : 0, lock);
}

void LiveSession::rendered(const Batch& batch) {
  parts_.metrics.rendered(batch.samples, batch.seconds, batch.dropped_samples);
  const std::lock_guard lock(mutex_);
  samples_since_ += batch.samples;
  dropped_samples_ += batch.dropped_samples;
}

void LiveSession::picture(RenderedPicture picture) {
  if (parts_.mark_frames) draw_frame_mark(picture.picture, picture.info.input_seq);
  keep_if_last(picture);
  const Lanes all = lanes();
  for (std::size_t i = 0; i + 1 < all.size(); ++i) all[i]->slot->submit(picture);
  if (!all.empty()) all.back()->slot->submit(std::move(picture));
}

void LiveSession::failed(const Error& why) {
  log::warning("session_failed", {{"session", id_}, {"code", to_string(why.code)}});
  end(why);
  on_ended_(why);
}

Admitted LiveSession::admit(const Lane& lane, const FrameInfo& frame) {
  const std::lock_guard lock(mutex_);
  if (!in_use(lane)) return {};
  return render::admit(state_, lane.codec, frame, parts_.clock.now());
}

void LiveSession::coded(const Lane& lane, const FrameInfo& frame, Canvas size, CodedFrame data,
                        double seconds) {
  parts_.metrics.encoded(seconds);
  {
    const std::lock_guard lock(mutex_);
    if (!in_use(lane)) return;
    const std::size_t bytes = data.data.size();
    const Departures departures =
        depart(state_, lane.codec, frame, {data.key, bytes}, parts_.clock.now());
    v1::ServerMessage message;
    v1::Frame& out = *message.mutable_frame();
    out.set_codec(data.codec);
    out.set_key(data.key);
    out.set_epoch(frame.epoch);
    out.set_input_seq(frame.input_seq);
    out.set_iteration(frame.samples);
    out.set_error(frame.error);
    out.set_width(size.width);
    out.set_height(size.height);
    out.set_denoised(frame.denoised);
    out.set_render_us(frame.render_us);
    out.set_encode_us(static_cast<std::uint64_t>(seconds * 1e6));
    out.set_quality(frame.moving ? v1::MOVING : v1::SETTLED);
    out.set_decoder(std::move(data.decoder));
    out.set_data(std::move(data.data));
    for (const Departure& departure : departures.frames) {
      if (departure.look) send_look(departure.connection);
      out.set_seq(departure.seq);
      send(departure.connection, message);
      parts_.metrics.frame_sent(bytes);
      if (!departure.state) continue;
      v1::ServerMessage after;
      *after.mutable_state() = *departure.state;
      send(departure.connection, after);
    }
    if (departures.input_to_frame) parts_.metrics.input_to_frame(*departures.input_to_frame);
  }
  send_tiles();
  parts_.runner.wake();  // the slot is free again
}

void LiveSession::keep_if_last(RenderedPicture& picture) {
  if (!picture.info.converged) return;
  const std::lock_guard lock(mutex_);
  FrameInfo& info = picture.info;
  // A small moving picture may converge too, but it is not the end: that has the viewport's size.
  info.converged = picture.picture.size == state_.shown.viewport;
  if (!info.converged || info.moving) return;  // at rest it comes again, in its settled quality
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
      (void)source.get(due.tile + 1, due.format);  // coded while this one is on its way
      if (!coded) continue;
      send_tile(due, *coded, depart_tile(state_, due, tiles, coded->data.size(), now));
      sent = true;
    }
  }
}

void LiveSession::send_tile(const TileDue& due, const CodedTile& coded,
                            const Departure& departure) {
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
  out.set_seq(departure.seq);
  out.set_iteration(last_->info.samples);
  out.set_error(last_->info.error);
  send(due.connection, message);
  if (!departure.state) return;
  v1::ServerMessage after;
  *after.mutable_state() = *departure.state;
  send(due.connection, after);
}

void LiveSession::dropped(const Lane& lane, const Error& why) {
  log::error("encode_failed", {{"session", id_}, {"code", to_string(why.code)}});
  const std::lock_guard lock(mutex_);
  if (in_use(lane)) release(state_, lane.codec);
}

void LiveSession::send(std::uint64_t connection, const v1::ServerMessage& message) {
  const auto link = links_.find(connection);
  if (link != links_.end()) link->second->send(message.SerializeAsString());
}

void LiveSession::send_config(std::uint64_t connection) {
  Receiver* const receiver = state_.audience.find(connection);
  if (!receiver) return;
  v1::ServerMessage message;
  v1::Config& config = *message.mutable_config();
  const EngineInfo engine = parts_.engine.info();
  config.set_protocol(1);
  config.set_session_id(id_);
  config.set_codec(receiver->codec);
  config.set_engine(engine.engine);
  config.set_device(engine.device);
  *config.mutable_volume() = to_proto(volume_->header());
  if (state_.wanted.scene) *config.mutable_scene() = *state_.wanted.scene;
  config.set_input_seq(state_.wanted.input_seq);
  for (const v1::Preset& preset : presets_) *config.add_presets() = preset;
  config.set_follower(!state_.audience.presents(*receiver));
  receiver->look_version = state_.wanted.version;
  send(connection, message);
}

void LiveSession::send_look(std::uint64_t connection) {
  // To the presenter what is wanted, to a follower what is shown.
  const Receiver* const receiver = state_.audience.find(connection);
  if (!receiver) return;
  const Wanted& of = state_.audience.presents(*receiver) ? state_.wanted : state_.shown;
  if (!of.scene) return;
  v1::ServerMessage message;
  *message.mutable_look()->mutable_scene() = *of.scene;
  message.mutable_look()->set_input_seq(of.input_seq);
  send(connection, message);
}

void LiveSession::tell_audience() {
  if (!volume_) return;            // volume_ready does it
  if (state_.camera_only) return;  // the group does it
  for (const Receiver& receiver : state_.audience.receivers) {
    if (!receiver.greeted) continue;
    v1::ServerMessage message;
    *message.mutable_audience() = audience_for(state_.audience, receiver);
    send(receiver.connection, message);
  }
}

void LiveSession::carry_out(const Outcome& outcome, std::uint64_t connection,
                            std::unique_lock<std::mutex>& lock) {
  version_.store(state_.wanted.version, std::memory_order_relaxed);
  if (outcome.problem) {
    v1::ServerMessage message;
    *message.mutable_problem() = *outcome.problem;
    send(connection, message);
    if (outcome.problem->fatal()) {
      finish_link(connection, {ErrorCode::kInvalid, outcome.problem->message(), {}}, false);
      leave(connection);
    }
  }
  if (outcome.configure) {
    const Receiver* receiver = state_.audience.find(connection);
    if (const auto opened = open_lane(receiver->codec); !opened) {
      finish_link(connection, opened.error(), true);
      leave(connection);
    } else if (volume_) {  // before the volume is there, volume_ready does it
      send_config(connection);
    }
  }
  lead_branches();
  if (outcome.audience) tell_audience();
  if (outcome.presenter) {
    const Receiver* presenter = state_.audience.of(state_.audience.presenter);
    if (presenter) send_look(presenter->connection);
  }
  const Lanes poked = outcome.room ? lanes_ : Lanes{};
  lock.unlock();
  for (const auto& lane : poked) lane->slot->poke();
  if (outcome.room) send_tiles();
  if (outcome.wake) parts_.runner.wake();
}

void LiveSession::finish_link(std::uint64_t connection, const Error& why, bool with_problem) {
  const auto link = links_.find(connection);
  if (link == links_.end()) return;
  if (with_problem) {
    v1::ServerMessage message;
    *message.mutable_problem() = problem_of(why, 0, true);
    send(connection, message);
  }
  link->second->finish(why);
  links_.erase(link);
}

void LiveSession::leave(std::uint64_t connection) {
  render::detach(state_, connection, parts_.clock.now());
  close_unused_lanes();
  tell_audience();
}

Result<void> LiveSession::open_lane(v1::Codec codec) {
  for (const auto& lane : lanes_) {
    if (lane->codec == codec) return {};
  }
  auto encoder = make_encoder(codec);
  if (!encoder) return tl::unexpected(encoder.error());
  auto lane = std::make_shared<Lane>(weak_from_this(), codec);
  lane->slot = std::make_shared<EncodeLane>(parts_.encoders, std::move(*encoder), lane);
  lanes_.push_back(std::move(lane));
  return {};
}

// An encoder may hold a device's resources, and a picture less is to be coded.
void LiveSession::close_unused_lanes() {
  std::erase_if(lanes_, [&](const auto& lane) {
    const auto& receivers = state_.audience.receivers;
    const bool used = std::any_of(receivers.begin(), receivers.end(), [&](const Receiver& one) {
      return one.greeted && !one.own_camera && one.codec == lane->codec;
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

LiveSession::Lanes LiveSession::lanes() const {
  const std::lock_guard lock(mutex_);
  return lanes_;
}

}  // namespace diaphane::render
