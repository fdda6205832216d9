#include "bench/schedule/trace.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

namespace diaphane::render::bench {
namespace {

/// Random numbers by SplitMix64, because the standard's distributions differ between libraries.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : state_(seed) {}
  double uniform() { return (static_cast<double>(next() >> 11) + 0.5) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  double lognormal(double median, double deviation) {
    const double radius = std::sqrt(-2 * std::log(uniform()));
    return median * std::exp(deviation * radius * std::cos(2 * std::numbers::pi * uniform()));
  }

 private:
  std::uint64_t next() {
    std::uint64_t x = state_ += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
  }
  std::uint64_t state_;
};

struct Habit {
  double drags = 1, looks = 1;  // medians in seconds
  bool looks_away = false;
};
constexpr Habit kBusy{1.5, 1, false}, kOccasional{1, 5, false}, kIdle{0.5, 30, true};

Habit habit_of(std::string_view kind, std::size_t person) {
  if (kind == "interactive") return kBusy;
  if (kind == "idle") return person % 8 == 0 ? kOccasional : kIdle;
  return person % 4 == 0 ? kBusy : person % 4 == 3 ? kIdle : kOccasional;
}

TraceSession session_of(const Habit& habit, double seconds, Draws& draws) {
  TraceSession session;
  session.arrives = draws.uniform(0, 0.1 * seconds);
  session.leaves = draws.uniform() < 0.05 ? draws.uniform(0.5, 1) * seconds : seconds;
  const double size = draws.uniform();
  session.viewport = size < 0.5    ? Canvas{512, 512}
                     : size < 0.75 ? Canvas{256, 256}
                                   : Canvas{1024, 768};
  const double scene = draws.uniform();
  session.scene = kTraceScenes[scene < 0.5 ? 0 : scene < 0.75 ? 1 : 2];
  // A user who was there before the trace starts at a random point of a pause.
  double now = session.arrives + draws.lognormal(habit.looks, 0.8) * draws.uniform();
  while (now < session.leaves) {
    const double end = std::min(now + draws.lognormal(habit.drags, 0.6), session.leaves);
    session.gestures.push_back({now, end});
    const double pause = draws.lognormal(habit.looks, 0.8);
    if (habit.looks_away && pause > 4 && draws.uniform() < 0.5) {
      session.hidden.push_back({std::min(end + 0.3 * pause, session.leaves),
                                std::min(end + 0.9 * pause, session.leaves)});
    }
    now = end + pause;
  }
  return session;
}

nlohmann::json json_of(const std::vector<Span>& spans) {
  auto list = nlohmann::json::array();
  for (const Span& span : spans) list.push_back({span.begin, span.end});
  return list;
}

std::vector<Span> spans_of(const nlohmann::json& list) {
  std::vector<Span> spans;
  for (const auto& each : list) spans.push_back({each.at(0), each.at(1)});
  return spans;
}

}  // namespace

Trace make_trace(std::string_view kind, std::size_t sessions, double seconds, std::uint64_t seed) {
  Trace trace{std::string(kind), seed, seconds, {}};
  for (std::size_t person = 0; person < sessions; ++person) {
    // Each session has its own stream, so that additional sessions do not change the first ones.
    Draws draws(seed * 1'000'003 + person * 7919);
    trace.sessions.push_back(session_of(habit_of(kind, person), seconds, draws));
  }
  return trace;
}

std::vector<TraceEvent> events_of(const Trace& trace) {
  using Kind = TraceEvent::Kind;
  std::vector<TraceEvent> events;
  for (std::size_t i = 0; i < trace.sessions.size(); ++i) {
    const TraceSession& session = trace.sessions[i];
    events.push_back({session.arrives, Kind::kArrive, i, true});
    for (const Span& gesture : session.gestures) {
      for (double t = gesture.begin; t < gesture.end - 0.5 * kInputInterval; t += kInputInterval) {
        events.push_back({t, Kind::kInput, i, false});
      }
      events.push_back({gesture.end, Kind::kInput, i, true});
    }
    for (const Span& span : session.hidden) {
      events.push_back({span.begin, Kind::kHide, i});
      events.push_back({span.end, Kind::kShow, i});
    }
    events.push_back({session.leaves, Kind::kLeave, i});
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const TraceEvent& a, const TraceEvent& b) { return a.at < b.at; });
  return events;
}

std::string trace_json(const Trace& trace) {
  nlohmann::ordered_json json{{"kind", trace.kind},
                              {"seed", trace.seed},
                              {"seconds", trace.seconds},
                              {"sessions", nlohmann::json::array()}};
  for (const TraceSession& session : trace.sessions) {
    json["sessions"].push_back({{"arrives", session.arrives},
                                {"leaves", session.leaves},
                                {"width", session.viewport.width},
                                {"height", session.viewport.height},
                                {"scene", session.scene},
                                {"gestures", json_of(session.gestures)},
                                {"hidden", json_of(session.hidden)}});
  }
  return json.dump(1) + "\n";
}

Result<Trace> trace_of_json(const std::string& text) try {
  const auto json = nlohmann::json::parse(text);
  Trace trace{json.at("kind"), json.at("seed"), json.at("seconds"), {}};
  for (const auto& each : json.at("sessions")) {
    TraceSession session;
    session.arrives = each.at("arrives");
    session.leaves = each.at("leaves");
    session.viewport = {each.at("width"), each.at("height")};
    session.scene = each.at("scene");
    session.gestures = spans_of(each.at("gestures"));
    session.hidden = spans_of(each.at("hidden"));
    trace.sessions.push_back(std::move(session));
  }
  return trace;
} catch (const nlohmann::json::exception& error) {
  return fail(ErrorCode::kInvalid, std::string("not a trace: ") + error.what(), "--trace");
}

}  // namespace diaphane::render::bench
