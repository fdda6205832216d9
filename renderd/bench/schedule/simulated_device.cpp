#include "renderd/bench/schedule/simulated_device.h"

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
  Wanted wanted;
  Ledger ledger{0};
};

struct SimulatedDevice::Turn {
  Session* session = nullptr;
  std::uint32_t samples = 0;
  double seconds = 0;  // alone
  double fill = 1;
};

SimulatedDevice::SimulatedDevice(const DeviceModel& model, std::unique_ptr<Policy> policy,
                                 LedgerRules rules)
    : model_(model), policy_(std::move(policy)), rules_(rules) {
  rules_.device_parallel = model.parallel;
}

SimulatedDevice::~SimulatedDevice() = default;

// Not the epoch: there a Ledger takes a time for none.
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
      sessions_.push_back(std::make_unique<Session>(event.session, *trace, *score));
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
        ++session.wanted.version;
        ++session.wanted.input_seq;
        session.wanted.last_input = time_point(event.at);
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
        sessions_.erase(found);
        break;
    }
  }
}

void SimulatedDevice::emit(Session& session) {
  const auto question = session.ledger.emission(rules_, time_point(now_));
  if (!question || !should_emit(*question)) return;
  const double seconds =
      model_.picture_seconds + model_.picture_seconds_per_pixel * pixels(session.ledger.canvas());
  now_ += seconds;
  time_.pictures += seconds;
  session.ledger.shown(seconds, costs_, time_point(now_));
  session.score->frame(now_, session.ledger.progress().error);
}

bool SimulatedDevice::step() {
  deliver();
  std::vector<SessionView> views;
  views.reserve(sessions_.size());
  for (const auto& session : sessions_) {
    session->ledger.refresh(session->wanted, costs_, rules_, time_point(now_));
    session->wanted.picture_again = false;
    emit(*session);
  }
  for (const auto& session : sessions_) {
    views.push_back(session->ledger.view(session->index + 1, costs_, rules_, time_point(now_)));
  }
  const std::vector<Quantum> round = policy_->next(views);
  if (round.empty()) return false;
  const double looking = model_.look_seconds * static_cast<double>(sessions_.size());
  now_ += looking;
  time_.switching += looking;
  carry_out(round);
  return true;
}

void SimulatedDevice::carry_out(const std::vector<Quantum>& round) {
  std::vector<Turn> turns;
  double scenes = 0;
  for (const Quantum& quantum : round) {
    const auto found = std::find_if(sessions_.begin(), sessions_.end(),
                                    [&](const auto& s) { return s->index + 1 == quantum.session; });
    Session& session = **found;
    Ledger& ledger = session.ledger;
    if (ledger.stale()) {
      session.score->began(now_);
      ledger.began(model_.scene_seconds, time_point(now_));
      scenes += model_.scene_seconds;
    }
    Turn turn{&session, quantum.samples, 0, 1};
    turn.seconds = model_.alone(session.trace->scene, ledger.canvas(), quantum.samples);
    if (model_.parallel > 0) {
      turn.fill = std::min(1.0, pixels(ledger.canvas()) * quantum.samples / model_.parallel);
    }
    // Newer input of its own cuts it short, at the end of a sample.
    if (ledger.interruptible()) {
      const double end = now_ + scenes + model_.quantum_seconds + turn.seconds;
      for (const Coming& coming : coming_) {
        if (coming.event.at >= end) break;
        if (coming.event.session != session.index) continue;
        const double share =
            std::max(0.0, (coming.event.at - now_ - scenes) / (end - now_ - scenes));
        turn.samples = static_cast<std::uint32_t>(share * turn.samples);
        turn.seconds *= share;
        break;
      }
    }
    turns.push_back(turn);
  }
  double longest = 0, work = 0, filled = 0;
  for (const Turn& turn : turns) {
    longest = std::max(longest, turn.seconds);
    work += turn.seconds * turn.fill;
    filled += turn.fill;
  }
  const double rendering = std::max(longest, work);
  now_ += scenes + rendering + model_.quantum_seconds;
  time_.scenes += scenes;
  time_.rendering += rendering;
  time_.switching += model_.quantum_seconds;
  time_.quanta += turns.size();
  for (const Turn& turn : turns) {
    Ledger& ledger = turn.session->ledger;
    Progress progress = ledger.progress();
    progress.samples += turn.samples;
    progress.seconds += turn.seconds;
    const double noise = model_.scene(turn.session->trace->scene).noise;
    progress.error = progress.samples < 2 ? std::numeric_limits<double>::infinity()
                                          : noise / std::sqrt(double(progress.samples));
    ledger.rendered({turn.samples, turn.seconds + model_.quantum_seconds, 0}, progress, costs_,
                    time_point(now_));
  }
}

void SimulatedDevice::run_until(double seconds) {
  while (now_ < seconds) {
    if (step()) continue;
    // Nobody gains: until something happens, or a moving picture comes to rest.
    double next = std::min(next_event(), seconds);
    for (const auto& session : sessions_) {
      if (!session->ledger.moving()) continue;
      const double rest =
          std::chrono::duration<double>(session->wanted.last_input - time_point(0)).count() +
          kRestSeconds + 1e-6;
      if (rest > now_) next = std::min(next, rest);
    }
    next = std::max(next, now_ + 1e-6);
    time_.idle += next - now_;
    now_ = next;
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
