#include "bench/load/load_run.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "bench/load/load_report.h"
#include "common/try.h"
#include "directory/client.h"
#include "directory/sessions.h"

namespace diaphane::api::load {
namespace {

using Json = nlohmann::ordered_json;

Result<Json> one_run(Stage& stage, Placement& placement, const CrowdOptions& options) {
  Usage before, after;
  auto result =
      run_crowd(options, placement, [&](bool over) { (over ? after : before) = stage.usage(); });
  DIAPHANE_TRY(result);
  return load_report(options, std::move(*result), before, after);
}

bool held(const Json& report, double bound_seconds) {
  return report.at("opened") == report.at("sessions") && report.at("closed").empty() &&
         report.at("input_to_frame_ms").at("p95").get<double>() <= 1e3 * bound_seconds;
}

}  // namespace

void Search::tried(bool was_held) {
  (was_held ? held_ : failed_) = next_;
  if (failed_ == 0) {
    next_ = held_ == most_ ? 0 : std::min(2 * held_, most_);
    return;
  }
  const std::size_t step = std::max<std::size_t>(1, failed_ / 16);
  next_ = failed_ - held_ > step ? (failed_ + held_) / 2 : 0;
}

Result<Json> load_run(LoadOptions options, const std::function<void(const std::string&)>& print) {
  const CrowdOptions asked = options.crowd;
  options.stage.slots =
      std::max(options.stage.slots, options.find ? options.most_sessions : asked.sessions);
  auto stage = Stage::set(options.stage);
  DIAPHANE_TRY(stage);
  auto client = directory::Client::create({.address = (*stage)->redis()});
  DIAPHANE_TRY(client);
  directory::Sessions placement(**client);

  Json all{{"bound_ms", 1e3 * options.bound_seconds}, {"runs", Json::array()}};
  print(load_heading());
  const auto run = [&](std::size_t sessions) -> Result<Json> {
    CrowdOptions crowd = asked;
    crowd.sessions = sessions;
    // Keeps the share of moving sessions.
    crowd.moving = std::max<std::size_t>(
        1, static_cast<std::size_t>(std::lround(double(asked.moving) * double(sessions) /
                                                double(std::max<std::size_t>(asked.sessions, 1)))));
    crowd.data_set = (*stage)->volume_id();
    crowd.viewer.port = (*stage)->stream_port();
    crowd.viewer.origin = (*stage)->origin();
    crowd.seed += all["runs"].size();
    auto report = one_run(**stage, placement, crowd);
    if (!report) return report;
    if (!(*stage)->stands()) return fail(ErrorCode::kUnavailable, "a program exited unexpectedly");
    print(load_line(*report));
    all["runs"].push_back(*report);
    // The slots become free with the next heartbeat.
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    return report;
  };
  std::size_t times_held = 0;
  for (unsigned i = 0; i < options.repeats; ++i) {
    const auto report = run(asked.sessions);
    if (!report) return report;
    times_held += held(*report, options.bound_seconds);
  }
  all["held"] = times_held == options.repeats;
  if (!options.find) return all;

  Search search(asked.sessions, options.most_sessions);
  search.tried(times_held == options.repeats);
  while (search.next() != 0) {
    const auto report = run(search.next());
    if (!report) return report;
    search.tried(held(*report, options.bound_seconds));
  }
  all["largest_held"] = search.largest_held();
  print("largest number of sessions with p95 <= " +
        std::to_string(std::lround(1e3 * options.bound_seconds)) +
        " ms: " + std::to_string(search.largest_held()));
  return all;
}

}  // namespace diaphane::api::load
