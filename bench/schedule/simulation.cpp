#include "bench/schedule/simulation.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace diaphane::render::bench {
namespace {

constexpr double kHeartbeatSeconds = 1;

std::vector<SessionScore> scores_of(const Trace& trace, const DeviceModel& model) {
  std::vector<SessionScore> scores;
  for (const TraceSession& session : trace.sessions) {
    scores.emplace_back(model.to_good(session.scene, session.viewport));
  }
  return scores;
}

DeviceTime& operator+=(DeviceTime& sum, const DeviceTime& time) {
  sum.rendering += time.rendering;
  sum.scenes += time.scenes;
  sum.pictures += time.pictures;
  sum.switching += time.switching;
  sum.idle += time.idle;
  sum.quanta += time.quanta;
  return sum;
}

/// What the placement knows about a device.
struct Known {
  double summed_error = 0;  // at the last heartbeat, plus sessions placed since
  std::size_t count = 0;
};

std::size_t chosen(const std::vector<Known>& known, Placement placement, std::size_t turn) {
  if (placement == Placement::kRoundRobin) return turn % known.size();
  const auto less = [placement](const Known& a, const Known& b) {
    if (placement == Placement::kLeastCount) return a.count < b.count;
    return a.summed_error != b.summed_error ? a.summed_error < b.summed_error : a.count < b.count;
  };
  return static_cast<std::size_t>(
      std::distance(known.begin(), std::min_element(known.begin(), known.end(), less)));
}

}  // namespace

TraceRun simulate(const Trace& trace, const DeviceModel& model, std::unique_ptr<Policy> policy,
                  const LedgerRules& rules) {
  std::vector<SessionScore> scores = scores_of(trace, model);
  SimulatedDevice device(model, std::move(policy), rules);
  for (const TraceEvent& event : events_of(trace)) {
    device.happen(event, trace.sessions[event.session], scores[event.session]);
  }
  device.run_until(trace.seconds);
  for (SessionScore& each : scores) each.ended(trace.seconds);
  return {score(scores, device.time(), trace.seconds), device.time()};
}

std::string_view placement_name(Placement placement) {
  switch (placement) {
    case Placement::kSummedError:
      return "summed-error";
    case Placement::kLeastCount:
      return "least-count";
    case Placement::kRoundRobin:
      return "round-robin";
  }
  return "";
}

FleetRun simulate_fleet(const Trace& trace, std::size_t devices, const DeviceModel& model,
                        PolicyKind policy, Placement placement, const LedgerRules& rules) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<SessionScore> scores = scores_of(trace, model);
  std::vector<std::unique_ptr<SimulatedDevice>> fleet;
  for (std::size_t i = 0; i < devices; ++i) {
    fleet.push_back(
        std::make_unique<SimulatedDevice>(model, make_policy(policy, {}, i + 1), rules));
  }
  std::vector<Known> known(devices);
  std::vector<std::size_t> place(trace.sessions.size(), 0);
  std::size_t turn = 0;
  double heard = 0;
  // Devices are independent, so each is simulated only when its state is needed.
  const auto hear = [&](double now) {
    for (std::size_t i = 0; i < devices; ++i) {
      fleet[i]->run_until(now);
      known[i] = {fleet[i]->summed_error(), fleet[i]->sessions()};
    }
  };
  for (const TraceEvent& event : events_of(trace)) {
    while (event.at >= heard + kHeartbeatSeconds) hear(heard += kHeartbeatSeconds);
    if (event.kind == TraceEvent::Kind::kArrive) {
      const std::size_t to = chosen(known, placement, turn++);
      place[event.session] = to;
      known[to].summed_error += 1;
      ++known[to].count;
    }
    fleet[place[event.session]]->happen(event, trace.sessions[event.session],
                                        scores[event.session]);
  }
  hear(trace.seconds);
  DeviceTime all;
  FleetRun run;
  run.fewest = trace.sessions.size();
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < devices; ++i) {
    const DeviceTime& time = fleet[i]->time();
    all += time;
    run.fewest = std::min(run.fewest, known[i].count);
    run.most = std::max(run.most, known[i].count);
    const double load = 1 - time.idle / trace.seconds;
    sum += load;
    squares += load * load;
  }
  const auto n = static_cast<double>(devices);
  run.load_deviation = std::sqrt(std::max(0.0, squares / n - sum / n * (sum / n)));
  for (SessionScore& each : scores) each.ended(trace.seconds);
  run.scores = score(scores, all, trace.seconds);
  run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return run;
}

}  // namespace diaphane::render::bench
