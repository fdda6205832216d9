#include "renderd/serve/live_session.h"

#include <google/protobuf/util/json_util.h>

#include <random>

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

LiveSession::LiveSession(SessionParts parts, Start start, std::function<void()> ended)
    : parts_(std::move(parts)),
      id_(start.id),
      volume_id_(start.volume_id),
      on_ended_(std::move(ended)) {
  state_.id = std::move(start.id);
  state_.volume_id = std::move(start.volume_id);
  state_.placement = start.placement;
  state_.wanted.scene = std::move(start.scene);
  state_.wanted.viewport = start.viewport;
  state_.wanted.input_seq = start.input_seq;
  state_.wanted.version = 1;
  version_ = 1;
  stats_since_ = parts_.clock.now();
}

std::uint64_t LiveSession::attach(std::shared_ptr<ClientLink> link, std::uint64_t placement) {
  const std::lock_guard lock(mutex_);
  finish_link({ErrorCode::kConflict, "This session was opened in another window.", {}}, true);
  link_ = std::move(link);
  state_.placement = placement;
  render::attach(state_, parts_.clock.now());
  if (lane_) lane_->request_key();
  return ++connection_;
}

void LiveSession::volume_ready(Result<std::shared_ptr<const DeviceVolume>> volume) {
  Result<std::unique_ptr<FrameRenderer>> renderer = fail(ErrorCode::kInternal, "");
  auto encoder = make_encoder(v1::JPEG);
  if (volume) renderer = parts_.engine.renderer(*volume, random_seed(), 0, kLiveMethod);
  if (!volume || !renderer || !encoder) {
    return failed(!volume ? volume.error() : !renderer ? renderer.error() : encoder.error());
  }
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
  lane_ = std::make_shared<EncodeLane>(parts_.encoders, std::move(*encoder), weak_from_this());
  runner_handle_ =
      parts_.runner.add(shared_from_this(), std::move(*renderer), first_epoch(state_.placement));
  if (state_.greeted) send_config();
}

void LiveSession::receive(std::uint64_t connection, const std::string& bytes) {
  v1::ClientMessage message;
  const bool sound = message.ParseFromString(bytes);
  std::unique_lock lock(mutex_);
  if (connection != connection_ || !link_) return;
  if (!sound) {
    finish_link({ErrorCode::kInvalid, "The page sent something that is no message.", {}}, true);
    render::detach(state_, parts_.clock.now());
    return;
  }
  carry_out(render::receive(state_, message, parts_.clock.now()), lock);
}

void LiveSession::closed(std::uint64_t connection) {
  {
    const std::lock_guard lock(mutex_);
    if (connection != connection_) return;
    link_.reset();
    render::detach(state_, parts_.clock.now());
  }
  parts_.runner.wake();
}

void LiveSession::end(const Error& why) {
  std::uint64_t handle = 0;
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return;
    ended_ = true;
    finish_link(why, true);
    handle = std::exchange(runner_handle_, 0);
  }
  if (handle != 0) parts_.runner.remove(handle);
}

void LiveSession::tick() {
  const std::lock_guard lock(mutex_);
  const TimePoint now = parts_.clock.now();
  if (greeting_overdue(state_, now)) {
    finish_link({ErrorCode::kInvalid, "The page did not say anything.", {}}, true);
    render::detach(state_, now);
  }
  const double seconds = std::chrono::duration<double>(now - stats_since_).count();
  if (seconds < 1) return;
  const std::uint64_t skipped = lane_ ? lane_->skipped() : 0;
  parts_.metrics.frames_skipped(skipped - skipped_told_);
  skipped_told_ = skipped;
  if (samples_since_ > 0 && state_.greeted && watched(state_, now)) {
    v1::ServerMessage message;
    v1::Stats& stats = *message.mutable_stats();
    stats.set_samples_per_second(static_cast<double>(samples_since_) / seconds);
    stats.set_sessions(static_cast<std::uint32_t>(parts_.session_count()));
    stats.set_dropped_samples(dropped_samples_);
    stats.set_frames_skipped(skipped);
    send(message);
  }
  stats_since_ = now;
  samples_since_ = 0;
}

std::uint64_t LiveSession::placement() const {
  const std::lock_guard lock(mutex_);
  return state_.placement;
}

std::optional<std::chrono::steady_clock::duration> LiveSession::abandoned_for() const {
  const std::lock_guard lock(mutex_);
  if (state_.attached) return std::nullopt;
  return parts_.clock.now() - state_.detached_since;
}

std::optional<LiveSession::Saved> LiveSession::take_unsaved() {
  const std::lock_guard lock(mutex_);
  if (!state_.unsaved || !state_.wanted.scene) return std::nullopt;
  state_.unsaved = false;
  return Saved{id_, state_.placement, state_.wanted.scene->SerializeAsString(),
               state_.wanted.input_seq, state_.wanted.viewport};
}

void LiveSession::mark_unsaved() {
  const std::lock_guard lock(mutex_);
  state_.unsaved = true;
}

Wanted LiveSession::wanted() {
  std::shared_ptr<EncodeLane> lane;
  {
    const std::lock_guard lock(mutex_);
    lane = lane_;
  }
  const bool slot_free = lane && lane->slot_free();
  const std::lock_guard lock(mutex_);
  Wanted wanted = state_.wanted;
  wanted.visible = watched(state_, parts_.clock.now());
  wanted.room = slot_free && state_.flight.room();
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
}

void LiveSession::refused(const Wanted& wanted, const Error& why) {
  std::unique_lock lock(mutex_);
  carry_out(render::refused(state_, wanted, why), lock);
}

void LiveSession::rendered(const Batch& batch) {
  parts_.metrics.rendered(batch.samples, batch.seconds, batch.dropped_samples);
  const std::lock_guard lock(mutex_);
  samples_since_ += batch.samples;
  dropped_samples_ += batch.dropped_samples;
}

void LiveSession::picture(RenderedPicture picture) {
  std::shared_ptr<EncodeLane> lane;
  {
    const std::lock_guard lock(mutex_);
    lane = lane_;
  }
  if (parts_.mark_frames) draw_frame_mark(picture.picture, picture.info.input_seq);
  if (lane) lane->submit(std::move(picture));
}

void LiveSession::failed(const Error& why) {
  log::warning("session_failed", {{"session", id_}, {"code", to_string(why.code)}});
  end(why);
  on_ended_();
}

Admission LiveSession::admit(const FrameInfo& frame) {
  const std::lock_guard lock(mutex_);
  return render::admit(state_, frame);
}

void LiveSession::coded(const FrameInfo& frame, Canvas size, CodedFrame data, double seconds) {
  parts_.metrics.encoded(seconds);
  {
    const std::lock_guard lock(mutex_);
    if (!still_useful(state_, frame)) {
      state_.flight.release();
    } else {
      const std::size_t bytes = data.data.size();
      const Departure departure = depart(state_, frame, parts_.clock.now());
      v1::ServerMessage message;
      v1::Frame& out = *message.mutable_frame();
      out.set_codec(data.codec);
      out.set_key(data.key);
      out.set_epoch(frame.epoch);
      out.set_seq(departure.seq);
      out.set_input_seq(frame.input_seq);
      out.set_iteration(frame.samples);
      out.set_error(frame.error);
      out.set_width(size.width);
      out.set_height(size.height);
      out.set_denoised(frame.denoised);
      out.set_render_us(frame.render_us);
      out.set_encode_us(static_cast<std::uint64_t>(seconds * 1e6));
      out.set_data(std::move(data.data));
      send(message);
      if (departure.state) {
        v1::ServerMessage after;
        *after.mutable_state() = *departure.state;
        send(after);
      }
      parts_.metrics.frame_sent(bytes);
      if (departure.input_to_frame) parts_.metrics.input_to_frame(*departure.input_to_frame);
    }
  }
  parts_.runner.wake();  // the slot is free again
}

void LiveSession::dropped(const FrameInfo&, const Error& why) {
  log::error("encode_failed", {{"session", id_}, {"code", to_string(why.code)}});
  const std::lock_guard lock(mutex_);
  state_.flight.release();
}

void LiveSession::send(const v1::ServerMessage& message) {
  if (link_) link_->send(message.SerializeAsString());
}

void LiveSession::send_config() {
  v1::ServerMessage message;
  v1::Config& config = *message.mutable_config();
  const EngineInfo engine = parts_.engine.info();
  config.set_protocol(1);
  config.set_session_id(id_);
  config.set_codec(state_.codec);
  config.set_engine(engine.engine);
  config.set_device(engine.device);
  *config.mutable_volume() = to_proto(volume_->header());
  if (state_.wanted.scene) *config.mutable_scene() = *state_.wanted.scene;
  config.set_input_seq(state_.wanted.input_seq);
  for (const v1::Preset& preset : presets_) *config.add_presets() = preset;
  send(message);
}

void LiveSession::carry_out(const Outcome& outcome, std::unique_lock<std::mutex>& lock) {
  version_.store(state_.wanted.version, std::memory_order_relaxed);
  if (outcome.problem) {
    v1::ServerMessage message;
    *message.mutable_problem() = *outcome.problem;
    send(message);
    if (outcome.problem->fatal()) {
      finish_link({ErrorCode::kInvalid, outcome.problem->message(), {}}, false);
      render::detach(state_, parts_.clock.now());
    }
  }
  // Before the volume is there, volume_ready does it.
  if (outcome.configure && volume_) send_config();
  const std::shared_ptr<EncodeLane> lane = outcome.room ? lane_ : nullptr;
  lock.unlock();
  if (lane) lane->poke();
  if (outcome.wake) parts_.runner.wake();
}

void LiveSession::finish_link(const Error& why, bool with_problem) {
  if (!link_) return;
  if (with_problem) {
    v1::ServerMessage message;
    *message.mutable_problem() = problem_of(why, 0, true);
    send(message);
  }
  link_->finish(why);
  link_.reset();
}

}  // namespace diaphane::render
