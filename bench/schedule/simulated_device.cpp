#include "bench/schedule/simulated_device.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderd/schedule/canvas.h"

namespace diaphane::render::bench {
namespace {

double pixels(Canvas canvas) { return double(canvas.width) * double(canvas.height); }

const std::shared_ptr<const v1::Scene>& any_scene() {
  static const auto scene = std::make_shared<const v1::Scene>();
  return scene;
}

}  // namespace

struct SimulatedDevice::Session {
  Session(std::size_t i, const TraceSession& t, SessionScore& s) : index(i), trace(&t), score(&s) {}

  std::size_t index;
  const TraceSession* trace;
  SessionScore* score;
  bool left = false;
  bool under_way = false;
  ViewRequest wanted;
  Ledger ledger{0};
  SessionView seen;
};

// The sequence of phases in a quantum. Of these, only samples and half of a picture need the
// device.
struct SimulatedDevice::Turn {
  enum class Phase { kScene, kSamples, kEnd, kPicture, kReadBack, kOver };

  SessionPtr session;
  std::uint32_t samples = 0;
  double alone = 0;  // seconds of the samples on an unshared device
  double fill = 1;
  Phase phase = Phase::kScene;
  double left = 0;  // remaining seconds of the phase on an unshared device

  bool on_device() const { return phase == Phase::kSamples || phase == Phase::kPicture; }
};

SimulatedDevice::SimulatedDevice(const DeviceModel& model, std::unique_ptr<Policy> policy,
                                 LedgerRules rules)
    : model_(model), policy_(std::move(policy)), rules_(rules) {
  rules_.device_parallel = model.parallel;
}

SimulatedDevice::~SimulatedDevice() = default;

// Never returns the epoch, which Ledger interprets as an unset time.
Ledger::Time SimulatedDevice::time_point(double seconds) const {
  return Ledger::Time(std::chrono::hours(1) + std::chrono::duration_cast<Ledger::Time::duration>(
                                                  std::chrono::duration<double>(seconds)));
}

void SimulatedDevice::happen(const TraceEvent& event, const TraceSession& session,
                             SessionScore& score) {
  coming_.push_back({event, &session, &score});
}

double SimulatedDevice::next_event() const {
  return coming_.empty() ? std::numeric_limits<double>::infinity() : coming_.front().event.at;
}

void SimulatedDevice::deliver() {
  using Kind = TraceEvent::Kind;
  for (; next_event() <= now_; coming_.pop_front()) {
    const auto& [event, trace, score] = coming_.front();
    if (event.kind == Kind::kArrive) {
      sessions_.push_back(std::make_shared<Session>(event.session, *trace, *score));
      sessions_.back()->wanted.scene = any_scene();
      sessions_.back()->wanted.viewport = trace->viewport;
    }
    const auto found = std::find_if(sessions_.begin(), sessions_.end(),
                                    [i = event.session](const auto& s) { return s->index == i; });
    if (found == sessions_.end()) continue;
    Session& session = **found;
    switch (event.kind) {
      case Kind::kArrive:
      case Kind::kInput:
        input(session, event);
        score->input(event.at, event.last);
        break;
      case Kind::kHide:
        session.wanted.visible = false;
        score->hidden(event.at);
        break;
      case Kind::kShow:
        session.wanted.visible = true;
        session.wanted.picture_again = true;
        break;
      case Kind::kLeave:
        score->ended(event.at);
        session.left = true;
        sessions_.erase(found);
        break;
    }
  }
}

void SimulatedDevice::input(Session& session, const TraceEvent& event) {
  ++session.wanted.version;
  ++session.wanted.input_seq;
  session.wanted.last_input = time_point(event.at);
  session.wanted.rest = event.last;
  if (!session.under_way || !session.ledger.interruptible()) return;
  // Interrupts the session's own quantum at the end of a sample.
  for (Turn& turn : turns_) {
    if (turn.session.get() != &session || turn.phase != Turn::Phase::kSamples) continue;
    turn.samples = static_cast<std::uint32_t>((1 - turn.left / turn.alone) * turn.samples);
    turn.alone -= turn.left;
    turn.left = 0;
  }
}

bool SimulatedDevice::due(Session& session) const {
  const auto input = session.ledger.emission(rules_, time_point(now_));
  return input && should_emit(*input);
}

// Corresponds to Runner::refresh_views and Runner::step.
void SimulatedDevice::fill() {
  for (bool begun = true; begun;) {
    begun = false;
    std::vector<SessionView> views;
    views.reserve(sessions_.size());
    std::size_t moving = 0;
    for (const SessionPtr& session : sessions_) {
      if (!session->under_way) {
        session->ledger.refresh(session->wanted, costs_, rules_, time_point(now_));
        session->wanted.picture_again = false;
        session->seen = session->ledger.view(session->index + 1, costs_, rules_, time_point(now_));
        if (due(*session)) begin(session, 0);
      }
      session->seen.under_way = session->under_way;
      if (session->ledger.moving() && session->wanted.visible) ++moving;
      views.push_back(session->seen);
    }
    costs_.moving_sessions = moving;
    if (!room_for_another(in_flight_, model_.queues)) return;
    for (const Quantum& quantum : policy_->next(views)) {
      const auto found = std::find_if(
          sessions_.begin(), sessions_.end(),
          [&](const SessionPtr& session) { return session->index + 1 == quantum.session; });
      begin(*found, quantum.samples);
      begun = true;
    }
  }
}

void SimulatedDevice::begin(const SessionPtr& session, std::uint32_t samples) {
  Turn turn;
  turn.session = session;
  turn.samples = samples;
  session->under_way = true;
  if (samples == 0) {
    turn.fill = 0;
    begin_picture(turn);
  } else {
    Ledger& ledger = session->ledger;
    turn.left = model_.look_seconds * static_cast<double>(sessions_.size());
    if (ledger.stale()) {
      session->score->began(now_);
      ledger.began(model_.scene_seconds, time_point(now_));
      turn.left += model_.scene_seconds;
    }
    turn.alone = model_.alone(session->trace->scene, ledger.canvas(), samples);
    if (model_.parallel > 0) {
      turn.fill = std::min(1.0, pixels(ledger.canvas()) * samples / model_.parallel);
    }
    ++time_.quanta;
  }
  in_flight_.begin(turn.fill, time_point(now_));
  turns_.push_back(std::move(turn));
}

void SimulatedDevice::begin_picture(Turn& turn) {
  turn.phase = Turn::Phase::kPicture;
  turn.left = model_.picture_device_share * model_.picture(turn.session->ledger.canvas());
}

void SimulatedDevice::next_phase(Turn& turn) {
  using Phase = Turn::Phase;
  Session& session = *turn.session;
  switch (turn.phase) {
    case Phase::kScene:
      turn.phase = Phase::kSamples;
      turn.left = turn.alone;
      return;
    case Phase::kSamples:
      turn.phase = Phase::kEnd;
      turn.left = model_.quantum_seconds;
      return;
    case Phase::kEnd:
      rendered(turn);
      in_flight_.rendered(turn.fill, time_point(now_));
      session.ledger.refresh(session.wanted, costs_, rules_, time_point(now_));
      session.wanted.picture_again = false;
      if (!session.left && due(session)) return begin_picture(turn);
      turn.phase = Phase::kOver;
      return;
    case Phase::kPicture:
      turn.phase = Phase::kReadBack;
      turn.left = (1 - model_.picture_device_share) * model_.picture(session.ledger.canvas());
      return;
    case Phase::kReadBack:
      session.ledger.shown(model_.picture(session.ledger.canvas()), costs_, time_point(now_));
      if (!session.left) session.score->frame(now_, session.ledger.progress().error);
      turn.phase = Phase::kOver;
      return;
    case Phase::kOver:
      return;
  }
}

void SimulatedDevice::rendered(Turn& turn) {
  Ledger& ledger = turn.session->ledger;
  Progress progress = ledger.progress();
  progress.samples += turn.samples;
  progress.seconds += turn.alone;
  const double noise = model_.scene(turn.session->trace->scene).noise;
  progress.error = progress.samples < 2 ? std::numeric_limits<double>::infinity()
                                        : noise / std::sqrt(double(progress.samples));
  ledger.rendered({turn.samples, turn.alone + model_.quantum_seconds, 0}, progress, costs_,
                  time_point(now_));
}

// Lets `seconds` pass. `rate`: speed of the work on the device.
void SimulatedDevice::pass(double seconds, double rate) {
  using Phase = Turn::Phase;
  const auto any = [this](Phase phase) {
    return std::any_of(turns_.begin(), turns_.end(),
                       [phase](const Turn& turn) { return turn.phase == phase; });
  };
  if (turns_.empty()) {
    time_.idle += seconds;
  } else if (any(Phase::kSamples)) {
    time_.rendering += seconds;
  } else if (any(Phase::kPicture) || any(Phase::kReadBack)) {
    time_.pictures += seconds;
  } else if (any(Phase::kEnd)) {
    time_.switching += seconds;  // the device is idle
  } else {
    time_.scenes += seconds;
  }
  for (Turn& turn : turns_) turn.left -= seconds * (turn.on_device() ? rate : 1);
  now_ += seconds;
}

void SimulatedDevice::advance(double until) {
  double filled = 0;
  for (const Turn& turn : turns_) {
    if (turn.on_device()) filled += turn.phase == Turn::Phase::kPicture ? 1 : turn.fill;
  }
  const double rate = filled > 1 ? 1 / filled : 1;
  double step = until - now_;
  for (const Turn& turn : turns_) {
    step = std::min(step, turn.left / (turn.on_device() ? rate : 1));
  }
  pass(std::max(step, 0.0), rate);
  for (Turn& turn : turns_) {
    if (turn.left > 1e-12) continue;
    next_phase(turn);
    if (turn.phase != Turn::Phase::kOver) continue;
    turn.session->under_way = false;
    in_flight_.end(time_point(now_));
  }
  std::erase_if(turns_, [](const Turn& turn) { return turn.phase == Turn::Phase::kOver; });
}

// Returns when a moving picture comes to rest, which requires another size.
double SimulatedDevice::next_rest() const {
  double next = std::numeric_limits<double>::infinity();
  for (const SessionPtr& session : sessions_) {
    if (session->under_way || !session->ledger.moving()) continue;
    const double rest =
        std::chrono::duration<double>(session->wanted.last_input - time_point(0)).count() +
        kRestSeconds + 1e-6;
    if (rest > now_) next = std::min(next, rest);
  }
  return next;
}

void SimulatedDevice::run_until(double seconds) {
  while (now_ < seconds) {
    deliver();
    fill();
    advance(std::max(std::min({next_event(), next_rest(), seconds}), now_ + 1e-9));
  }
}

double SimulatedDevice::summed_error() const {
  double sum = 0;
  for (const auto& session : sessions_) {
    const SessionView view =
        session->ledger.view(session->index + 1, costs_, rules_, time_point(now_));
    if (gains(view)) sum += std::isfinite(view.error) ? std::min(view.error, 1.0) : 1.0;
  }
  return sum;
}

}  // namespace diaphane::render::bench
