#include "renderd/serve/live_session.h"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "common/log.h"
#include "common/try.h"
#include "renderd/scene/overlay_looks.h"
#include "renderd/scene/presets.h"
#include "renderd/serve/session_client.h"
#include "renderd/serve/session_lane.h"
#include "renderd/serve/session_turn.h"
#include "volume/header.h"
#include "volume/slice_interpolation.h"

namespace diaphane::render {
namespace {

// Returns the first epoch, which rises with each placement, so that a frame of the previous worker
// never passes for a new one.
std::uint64_t first_epoch(std::uint64_t placement) { return placement << 24; }

// Reduces the header to what a guest's page needs, without information about voxels that are not
// shown. The range of values becomes the range that the scene gives colours to.
void withhold(v1::VolumeHeader& header, const v1::TransferFunction& function) {
  header.clear_percentiles();
  header.clear_minimum();
  header.clear_maximum();
  bool first = true;
  for (const v1::Channel& channel : function.channels()) {
    for (const v1::OpacityPoint& point : channel.opacity()) {
      const auto value = static_cast<std::int32_t>(std::lround(point.value()));
      header.set_minimum(first ? value : std::min(header.minimum(), value));
      header.set_maximum(first ? value : std::max(header.maximum(), value));
      first = false;
    }
  }
}

v1::VolumeHeader header_for(ViewerKind viewer, const volume::Header& header,
                            const v1::TransferFunction& function) {
  v1::VolumeHeader message;
  // The JSON form is the only description of the header, and this conversion happens once per
  // connection.
  if (const auto json = volume::to_json(header)) {
    (void)google::protobuf::util::JsonStringToMessage(*json, &message);
  }
  if (viewer != ViewerKind::kOwner && viewer != ViewerKind::kShared) message.clear_content_hash();
  // Only ingest needs these fields.
  message.clear_origin();
  message.clear_frame_of_reference();
  message.clear_label_hash();
  if (viewer == ViewerKind::kGuest) withhold(message, function);
  return message;
}

std::uint64_t random_seed() {
  std::random_device device;
  return (std::uint64_t{device()} << 32) | device();
}

bool same_places(const std::vector<Double3>& a, const std::vector<Double3>& b) {
  return std::ranges::equal(a, b, [](const Double3& one, const Double3& other) {
    return one.x == other.x && one.y == other.y && one.z == other.z;
  });
}

}  // namespace

LiveSession::LiveSession(SessionParts parts, Start start, std::function<void(const Error&)> ended)
    : parts_(std::move(parts)),
      facts_(std::move(start.facts)),
      created_(parts_.clock.now()),
      visitor_(start.visitor),
      on_ended_(std::move(ended)),
      client_(std::make_shared<Client>(*this)) {
  state_.id = facts_.id;
  state_.volume_id = facts_.volume_id;
  state_.placement = start.placement;
  copy_.id = facts_.volume_id;
  if (start.scene) {
    copy_.with_table = start.scene->show_table();
    copy_.phase = start.scene->volume_phase();
  }
  state_.requested.scene = std::move(start.scene);
  state_.requested.viewport = start.viewport;
  state_.requested.input_seq = start.input_seq;
  state_.requested.version = 1;
  state_.camera_only = facts_.camera_only;
  state_.audience.guest_slices = start.guest_slices;
  if (!start.presenter.empty()) state_.audience.presenter = std::move(start.presenter);
  state_.codecs.clear();
  for (const v1::Codec codec : {v1::H264, v1::JPEG, v1::MPEG1}) {
    if (can_encode(codec)) state_.codecs.push_back(codec);
  }
  version_ = 1;
  stats_since_ = parts_.clock.now();
  state_.detached_since = stats_since_;
}

Result<std::uint64_t> LiveSession::attach(std::shared_ptr<ClientLink> link, const JoinRequest& join,
                                          Opening opening) {
  visitor_ = opening.visitor;
  const Turn turn(*this);
  const auto attached = render::attach(state_, join, turn.now);
  DIAPHANE_TRY(attached);
  if (attached->replaced) {
    finish_link(*attached->replaced,
                {ErrorCode::kConflict, "This session was opened in another window.", {}}, true);
  }
  links_.emplace(attached->connection, std::move(link));
  state_.placement = opening.placement;
  return attached->connection;
}

Result<std::unique_ptr<FrameRenderer>> LiveSession::renderer_of(
    const Result<VolumeCache::Handle>& volume) {
  DIAPHANE_TRY(volume);
  auto renderer = parts_.home->engine.renderer(*volume, random_seed(), 0, kLiveMethod);
  if (renderer && second_) {
    DIAPHANE_TRY((*renderer)->set_second(second_, facts_.second->to_first));
  }
  return renderer;
}

void LiveSession::start() {
  parts_.volumes.get(copy_, [self = shared_from_this()](Result<VolumeCache::Handle> volume) {
    self->volume_ready(std::move(volume));
  });
}

void LiveSession::volume_ready(Result<VolumeCache::Handle> volume) {
  if (volume && facts_.second && !second_) {
    // The first scan counts as in use meanwhile, so that both are known to fit.
    return parts_.volumes.get(
        {facts_.second->volume_id, false, 0},
        [self = shared_from_this(), first = *volume](Result<VolumeCache::Handle> second) {
          self->second_ready(first, std::move(second));
        });
  }
  show_first_volume(std::move(volume));
  if (!ended_) load_phases();
}

void LiveSession::second_ready(VolumeCache::Handle first, Result<VolumeCache::Handle> second) {
  if (!second) return failed(second.error());
  {
    const std::lock_guard lock(mutex_);
    second_ = *std::move(second);
  }
  volume_ready(std::move(first));
}

void LiveSession::show_first_volume(Result<VolumeCache::Handle> volume) {
  auto renderer = renderer_of(volume);
  if (!renderer) return failed(renderer.error());
  const VolumeStats stats = parts_.stats.of(**volume);
  std::vector<v1::Preset> presets = presets_for(
      (*volume)->header(), parts_.stats.framing_of(**volume), stats.contrast_agent, stats.brain);
  if (presets.empty()) {
    return failed({ErrorCode::kUnsupported, "This type of scan can't be displayed.", {}});
  }

  const Turn turn(*this);
  if (ended_) return;
  volume_ = std::move(*volume);
  state_.shown.volume = volume_;  // the renderer has it, although it has shown nothing yet
  const std::uint32_t phases = volume_->header().phase_count();
  copy_.phase = std::min(copy_.phase, phases - 1);
  const volume::Header stored = volume::stored_header(volume_->header());
  apply(slices_.handle(SlicesKnown{stacks_of(stored), stored}));
  presets_ = std::move(presets);
  // This program may reject a scene that an older version wrote. A default look is better than no
  // picture.
  if (state_.requested.scene && !check_scene(*state_.requested.scene)) {
    fallback_clip_ = state_.requested.scene->clip();
    state_.requested.scene.reset();
  }
  if (!state_.requested.scene) state_.requested.scene = first_look();
  runner_handle_ =
      parts_.home->runner.add(std::shared_ptr<RenderClient>(shared_from_this(), client_.get()),
                              std::move(*renderer), first_epoch(state_.placement));
  for (const Receiver& receiver : state_.audience.receivers) {
    if (receiver.greeted) send_config(receiver.connection);
  }
  apply(cameras_.handle(SceneChanged{}, state_));
  broadcast_participants();
}

std::shared_ptr<const v1::Scene> LiveSession::first_look() const {
  auto look = std::make_shared<v1::Scene>(presets_.front().scene());
  if (second_) {
    const auto looks = overlay_looks(volume_->header(), second_->header());
    *look->mutable_overlay() = looks.front().overlay();
  }
  if (fallback_clip_) {
    *look->mutable_clip() = *fallback_clip_;
    if (!check_scene(*look)) look->clear_clip();
  }
  return look;
}

void LiveSession::receive(std::uint64_t connection, const std::string& bytes) {
  v1::ClientMessage message;
  if (message.ParseFromString(bytes)) return dispatch(connection, message);
  const Turn turn(*this);
  if (!links_.contains(connection)) return;
  finish_link(connection, {ErrorCode::kInvalid, "The page sent an invalid message.", {}}, true);
  leave(connection);
}

void LiveSession::dispatch(std::uint64_t connection, const v1::ClientMessage& message) {
  const Turn turn(*this);
  if (!links_.contains(connection)) return;
  if (auto refused = refused_request(state_, connection, message)) {
    Outcome outcome;
    outcome.problem = std::move(*refused);
    return apply(outcome, connection);
  }
  switch (message.body_case()) {
    case v1::ClientMessage::kSlices:
      return apply(slices_.handle(SlicesRequested{connection, message.slices()}, state_, turn.now));
    case v1::ClientMessage::kKeyView:
      return apply(files_.handle(KeyViewSent{connection, message.key_view()}, state_));
    case v1::ClientMessage::kFileMark:
      return apply(files_.handle(FileMarkSent{connection, message.file_mark()}, state_));
    case v1::ClientMessage::kFile:
      return apply(files_.handle(
          FileRequested{connection, message.file(), ended_ ? nullptr : volume_}, state_));
    case v1::ClientMessage::kFileTaken:
      return apply(files_.handle(FileTaken{connection, message.file_taken().seq()}, state_));
    case v1::ClientMessage::kSliceView:
      // Handled first, so that guests learn that they have access to slices before they get the
      // view.
      apply(render::receive(state_, connection, message, turn.now), connection);
      return apply(
          collaboration_.handle(SliceViewSent{connection, message.slice_view()}, state_, turn.now));
    case v1::ClientMessage::kMeasurements:
      return apply(collaboration_.handle(MeasurementsSent{connection, message.measurements()},
                                         state_, turn.now));
    case v1::ClientMessage::kPointer:
      return apply(
          collaboration_.handle(PointerMoved{connection, message.pointer()}, state_, turn.now));
    case v1::ClientMessage::kMarks:
      return apply(collaboration_.handle(MarksSent{connection, message.marks()}, state_, turn.now));
    case v1::ClientMessage::kMarkSight:
      return apply(collaboration_.handle(MarkSightRequested{connection}, state_, turn.now));
    case v1::ClientMessage::kSharedTaken:
      return apply(collaboration_.handle(SharedReceived{connection, message.shared_taken().seq()},
                                         state_, turn.now));
    default:
      break;
  }
  if (const auto* own = cameras_.of(connection); own && concerns_picture(message)) {
    return apply(Effects{effect::ForwardToCamera{own->session, own->connection, message}});
  }
  apply(render::receive(state_, connection, message, turn.now), connection);
}

std::shared_ptr<const CoarseVolume> LiveSession::coarse_of_shown() const {
  // The picture may show an earlier phase than `volume_`.
  return parts_.stats.of(state_.shown.volume ? *state_.shown.volume : *volume_).coarse;
}

CoarseSecond LiveSession::coarse_second() const {
  if (!second_) return {};
  return {parts_.stats.of(*second_).coarse, facts_.second->to_first};
}

std::optional<VisiblePoint> LiveSession::visible_at(double x, double y) const {
  std::unique_lock lock(mutex_);
  if (!volume_ || !state_.shown.scene) return std::nullopt;
  const std::shared_ptr<const v1::Scene> scene = state_.shown.scene;
  const Canvas canvas = state_.shown.viewport;
  const auto coarse = coarse_of_shown();
  const CoarseSecond second = coarse_second();
  lock.unlock();
  return coarse ? visible_point_at(*coarse, *scene, canvas, x, y, second) : std::nullopt;
}

std::vector<bool> LiveSession::hidden_marks(const std::vector<Double3>& places) {
  std::unique_lock lock(mutex_);
  if (!volume_ || !state_.shown.scene) return std::vector<bool>(places.size());
  const ViewRequest shown = state_.shown;
  if (mark_sight_.version == shown.version && same_places(mark_sight_.places, places)) {
    return mark_sight_.hidden;
  }
  const auto coarse = coarse_of_shown();
  const CoarseSecond second = coarse_second();
  lock.unlock();
  MarkSight sight{shown.version, places, std::vector<bool>(places.size())};
  if (coarse) sight.hidden = hidden_places(*coarse, *shown.scene, shown.viewport, places, second);
  lock.lock();
  mark_sight_ = sight;
  return std::move(sight.hidden);
}

void LiveSession::carry_out(const effect::FindDepth& effect) {
  const v1::DepthQuery& query = effect.query;
  v1::ServerMessage message;
  v1::Depth& depth = *message.mutable_depth();
  depth.set_id(query.id());
  std::uint32_t label = 0;
  if (const auto visible = visible_at(query.x(), query.y())) {
    depth.set_found(true);
    depth.set_distance(visible->distance);
    depth.mutable_place()->set_x(visible->place.x);
    depth.mutable_place()->set_y(visible->place.y);
    depth.mutable_place()->set_z(visible->place.z);
    label = visible->label;
  }
  const std::lock_guard lock(mutex_);
  const Receiver* const receiver = state_.audience.find(effect.connection);
  if (receiver && may_know_labels(receiver->viewer)) depth.set_label(label);
  send(effect.connection, message);
}

void LiveSession::closed(std::uint64_t connection) {
  const Turn turn(*this);
  apply(cameras_.handle(ViewerLeft{connection}));
  if (links_.erase(connection) != 0) leave(connection);
  apply(Effects{effect::WakeRunner{}});
}

void LiveSession::end(const Error& why) {
  const Turn turn(*this);
  if (ended_.exchange(true)) return;
  note(convergence_.ended());
  apply(cameras_.handle(SessionEnded{}));
  while (!links_.empty()) finish_link(links_.begin()->first, why, true);
  apply(slices_.handle(AllViewersLeft{}));
  apply(files_.handle(SessionEnded{}));
  if (const auto handle = std::exchange(runner_handle_, 0); handle != 0) {
    apply(Effects{effect::LeaveRunner{handle}});
  }
}

void LiveSession::tick(std::size_t sessions) {
  const Turn turn(*this);
  for (const std::uint64_t silent : overdue_greetings(state_, turn.now)) {
    finish_link(silent, {ErrorCode::kInvalid, "The page did not send a greeting in time.", {}},
                true);
    leave(silent);
  }
  if (turn.now - stats_since_ >= std::chrono::seconds(1)) report_stats(sessions, turn.now);
  // Needed because the presenter may stall, or a key frame become due, without any message.
  apply(Effects{effect::PokeEncoders{}});
  apply(slices_.handle(SlicesTicked{}, state_, turn.now));
}

void LiveSession::report_stats(std::size_t sessions, TimePoint now) {
  std::uint64_t skipped = skipped_before_;
  for (const auto& lane : lanes_) skipped += lane->slot->skipped();
  parts_.metrics.frames_skipped(skipped - skipped_reported_);
  skipped_reported_ = skipped;
  const double seconds = std::chrono::duration<double>(now - stats_since_).count();
  const auto samples = static_cast<double>(std::exchange(samples_since_, 0));
  stats_since_ = now;
  if (samples == 0) return;
  v1::ServerMessage message;
  v1::Stats& stats = *message.mutable_stats();
  stats.set_samples_per_second(samples / seconds);
  stats.set_sessions(static_cast<std::uint32_t>(sessions));
  stats.set_dropped_samples(dropped_samples_);
  stats.set_frames_skipped(skipped);
  for (const Receiver& receiver : state_.audience.receivers) {
    if (is_watching(receiver, now)) send(receiver.connection, message);
  }
}

SessionStatus LiveSession::status() const {
  const std::lock_guard lock(mutex_);
  const TimePoint now = parts_.clock.now();
  SessionStatus status{state_.placement, device_seconds_, visitor_, now - created_, std::nullopt};
  if (state_.audience.receivers.empty()) status.abandoned_for = now - state_.detached_since;
  return status;
}

std::optional<SavedSession> LiveSession::take_unsaved() {
  const std::lock_guard lock(mutex_);
  return render::take_unsaved(state_);
}

std::optional<RecoveryRecord> LiveSession::recovery_record() const {
  const std::lock_guard lock(mutex_);
  if (ended_ || facts_.user_id.empty()) return std::nullopt;
  auto record = render::recovery_record(state_, facts_.user_id, visitor_);
  if (record && facts_.second) {
    record->over = facts_.second->volume_id;
    record->to_first = volume::text_of(facts_.second->to_first);
  }
  return record;
}

v1::ErrorCurve LiveSession::error_curve() const {
  const std::lock_guard lock(mutex_);
  return to_proto(convergence_.curve(), state_.epoch);
}

void LiveSession::note(const Convergence::Measured& measured) {
  if (measured.seconds_to_five_percent) {
    parts_.metrics.time_to_five_percent(*measured.seconds_to_five_percent);
  }
  if (measured.error_at_rest) parts_.metrics.error_at_rest(*measured.error_at_rest);
}

void LiveSession::mark_unsaved() {
  const std::lock_guard lock(mutex_);
  state_.unsaved = true;
}

void LiveSession::failed(const Error& why) {
  log::warning("session_failed", {{"session", facts_.id}, {"code", to_string(why.code)}});
  end(why);
  on_ended_(why);
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
  const EngineInfo engine = parts_.home->engine.info();
  config.set_protocol(1);
  config.set_session_id(facts_.id);
  config.set_codec(receiver->codec);
  config.set_engine(engine.engine);
  config.set_device(engine.device);
  *config.mutable_volume() =
      header_for(receiver->viewer, volume::stored_header(volume_->header()),
                 (state_.requested.scene ? *state_.requested.scene : v1::Scene::default_instance())
                     .transfer_function());
  VolumeStats stats = parts_.stats.of(*volume_);
  config.mutable_treatment()->set_slices_per_stored(volume_->header().interpolated);
  config.mutable_treatment()->set_has_support(stats.has_support);
  if (stats.histogram.counts_size() > 0 && receiver->viewer != ViewerKind::kGuest) {
    *config.mutable_histogram() = std::move(stats.histogram);
  }
  for (const volume::SliceStack& stack : *slices_.stacks())
    *config.add_slice_stacks() = to_proto(stack);
  if (state_.requested.scene) *config.mutable_scene() = *state_.requested.scene;
  config.set_input_seq(state_.requested.input_seq);
  for (const v1::Preset& preset : presets_) *config.add_presets() = preset;
  if (second_) *config.mutable_second() = second_for(receiver->viewer);
  config.set_follower(!state_.audience.presents(*receiver));
  receiver->look_version = state_.requested.version;
  send(connection, message);
  if (stats.labels.labels_size() > 0) send_labels(*receiver, stats.labels);
  if (volume_->header().phase_count() > 1) send_phases(connection);
}

v1::SecondVolume LiveSession::second_for(ViewerKind viewer) const {
  v1::SecondVolume message;
  const v1::Scene& scene =
      state_.requested.scene ? *state_.requested.scene : v1::Scene::default_instance();
  *message.mutable_volume() = header_for(viewer, volume::stored_header(second_->header()),
                                         scene.overlay().transfer_function());
  VolumeStats stats = parts_.stats.of(*second_);
  if (stats.histogram.counts_size() > 0 && viewer != ViewerKind::kGuest) {
    *message.mutable_histogram() = std::move(stats.histogram);
  }
  for (const v1::OverlayLook& look : overlay_looks(volume_->header(), second_->header()))
    *message.add_looks() = look;
  return message;
}

void LiveSession::send_labels(const Receiver& receiver, const v1::Labels& labels) {
  if (!may_know_labels(receiver.viewer)) return;
  v1::ServerMessage message;
  *message.mutable_labels() = labels;
  send(receiver.connection, message);
}

void LiveSession::send_scene(std::uint64_t connection) {
  // The presenter receives the requested scene, followers the one that is shown.
  const Receiver* const receiver = state_.audience.find(connection);
  if (!receiver) return;
  const ViewRequest& of = state_.audience.presents(*receiver) ? state_.requested : state_.shown;
  if (!of.scene) return;
  v1::ServerMessage message;
  *message.mutable_look()->mutable_scene() = *of.scene;
  message.mutable_look()->set_input_seq(of.input_seq);
  send(connection, message);
}

void LiveSession::broadcast_participants() {
  if (!volume_) return;            // volume_ready() sends it
  if (state_.camera_only) return;  // the group sends it
  for (const Receiver& receiver : state_.audience.receivers) {
    if (!receiver.greeted) continue;
    v1::ServerMessage message;
    *message.mutable_audience() = audience_for(state_.audience, receiver);
    send(receiver.connection, message);
  }
  apply(collaboration_.handle(ParticipantsChanged{}, state_, parts_.clock.now()));
}

void LiveSession::apply(const Outcome& outcome, std::uint64_t connection) {
  publish_version();
  if (outcome.problem) {
    v1::ServerMessage message;
    *message.mutable_problem() = *outcome.problem;
    send(connection, message);
    if (outcome.problem->fatal()) {
      finish_link(connection, {ErrorCode::kInvalid, outcome.problem->message(), {}}, false);
      leave(connection);
    }
  }
  if (outcome.configure) carry_out(effect::Configure{connection});
  apply(cameras_.handle(SceneChanged{}, state_));
  apply(slices_.handle(SceneChanged{}, state_, parts_.clock.now()));
  if (outcome.audience) broadcast_participants();
  if (outcome.presenter) {
    const Receiver* presenter = state_.audience.of(state_.audience.presenter);
    if (presenter) send_scene(presenter->connection);
  }
  if (outcome.room) apply(Effects{effect::PokeEncoders{}});
  if (outcome.wake) apply(Effects{effect::WakeRunner{}});
  if (outcome.free_camera) {
    apply(cameras_.handle(CameraRequested{connection, *outcome.free_camera}, state_));
  }
  if (outcome.error_curve) {
    v1::ServerMessage message;
    *message.mutable_error_curve() = to_proto(convergence_.curve(), state_.epoch);
    send(connection, message);
  }
  if (outcome.good_views) apply(Effects{effect::FindGoodViews{connection}});
  if (outcome.depth) apply(Effects{effect::FindDepth{connection, *outcome.depth}});
}

void LiveSession::apply_to_presenter(const Outcome& outcome) {
  const Receiver* presenter = state_.audience.of(state_.audience.presenter);
  apply(outcome, presenter ? presenter->connection : 0);
}

void LiveSession::apply(Effects effects) {
  for (Effect& one : effects) {
    std::visit(
        [this](auto& asked) {
          if constexpr (kSendsOnly<std::decay_t<decltype(asked)>>) {
            carry_out(asked);
          } else {
            pending_.emplace_back(std::move(asked));
          }
        },
        one);
  }
}

void LiveSession::carry_out(const effect::Send& effect) {
  if (effect.message.has_slice()) parts_.metrics.slice_sent(effect.message.slice().data().size());
  send(effect.connection, effect.message);
}

void LiveSession::carry_out(const effect::Configure& effect) {
  const Receiver* const receiver = state_.audience.find(effect.connection);
  if (const auto opened = open_lane(receiver->codec); !opened) {
    finish_link(effect.connection, opened.error(), true);
    leave(effect.connection);
  } else if (volume_) {  // before the volume is loaded, volume_ready() sends it
    send_config(effect.connection);
  }
}

void LiveSession::carry_out(const effect::BroadcastParticipants&) { broadcast_participants(); }

void LiveSession::carry_out(const effect::Warn& effect) {
  log::warning(effect.event, {{"session", facts_.id}});
}

void LiveSession::carry_out(const effect::WakeRunner&) { parts_.home->runner.wake(); }

void LiveSession::carry_out(const effect::LeaveRunner& effect) {
  parts_.home->runner.remove(effect.handle);
}

void LiveSession::carry_out(const effect::PokeEncoders&) {
  Lanes poked;
  {
    const std::lock_guard lock(mutex_);
    poked = lanes_;
  }
  for (const auto& lane : poked) lane->slot->poke();
  send_tiles();
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
  apply(files_.handle(ViewerLeft{connection}));
}

void LiveSession::leave(std::uint64_t connection) {
  render::detach(state_, connection, parts_.clock.now());
  apply(files_.handle(ViewerLeft{connection}));
  if (state_.audience.receivers.empty()) apply(slices_.handle(AllViewersLeft{}));
  close_unused_lanes();
  broadcast_participants();
}

}  // namespace diaphane::render
