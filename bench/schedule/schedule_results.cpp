#include "bench/schedule/schedule_results.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "bench/renderer/text.h"
#include "bench/renderer/timing.h"

namespace diaphane::render::bench {
namespace {

using Json = nlohmann::ordered_json;

std::vector<double> figures(const std::vector<Scores>& runs, const Column& column) {
  std::vector<double> values;
  for (const Scores& run : runs) values.push_back(column.scale * (run.*column.figure));
  return values;
}

std::vector<Scores> scores_of(const FleetRow& row) {
  std::vector<Scores> scores;
  for (const FleetRun& run : row.runs) scores.push_back(run.scores);
  return scores;
}

Json json_of(const std::vector<Scores>& runs) {
  Json json;
  for (const Column& column : schedule_columns()) {
    const auto values = figures(runs, column);
    json[column.name] = {
        {"value", median_of(values)}, {"spread", deviation_of(values)}, {"unit", column.unit}};
  }
  return json;
}

std::vector<SessionView> random_views(std::size_t sessions, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<SessionView> views(sessions);
  for (std::size_t i = 0; i < sessions; ++i) {
    SessionView& view = views[i];
    view.session = i + 1;
    view.samples =
        uniform(random) < 0.1 ? 0 : 1 + static_cast<std::uint64_t>(999 * uniform(random));
    view.error = view.samples > 0 ? 0.5 / std::sqrt(double(view.samples))
                                  : std::numeric_limits<double>::infinity();
    view.target_error = 0.01;
    view.seconds_per_sample = 1e-4 + 1e-3 * uniform(random);
    view.seconds_first = 5e-4;
    view.seconds_since_input = 2 * uniform(random);
    view.seconds_unanswered = view.samples > 0 ? 0 : 0.02 * uniform(random);
    view.seconds_since_frame = 0.1 * uniform(random);
    view.seconds_since_begun = 0.1 * uniform(random);
    view.seconds_waiting = 0.4 * uniform(random);
    view.visible = uniform(random) < 0.9;
  }
  return views;
}

}  // namespace

const std::vector<Column>& schedule_columns() {
  static const std::vector<Column> columns{
      {"to 5% mean", "ms", 1e3, &Scores::to_good_mean},
      {"to 5% p95", "ms", 1e3, &Scores::to_good_p95},
      {"reached", "%", 1e2, &Scores::reached},
      {"first p50", "ms", 1e3, &Scores::first_p50},
      {"first p95", "ms", 1e3, &Scores::first_p95},
      {"first p99", "ms", 1e3, &Scores::first_p99},
      {"queue p50", "ms", 1e3, &Scores::queueing_p50},
      {"queue p95", "ms", 1e3, &Scores::queueing_p95},
      {"queue p99", "ms", 1e3, &Scores::queueing_p99},
      {"Jain", "", 1, &Scores::fairness},
      {"idle", "%", 1e2, &Scores::idle},
      {"switching", "%", 1e2, &Scores::switching},
      {"rendering", "%", 1e2, &Scores::rendering},
      {"pictures", "%", 1e2, &Scores::pictures},
      {"frames/s", "1/s", 1, &Scores::frames_per_second},
  };
  return columns;
}

std::string schedule_text(const ScheduleReport& report) {
  std::string text;
  print(text,
        "%s, %s; traces of %g s; medians over the seeds, +- standard deviation of the first\n",
        report.how.c_str(), report.device.c_str(), report.seconds);
  print(text, "%-12s %5s %-18s", "trace", "n", "policy");
  for (const Column& column : schedule_columns()) {
    print(text, " %10s", column.name);
    if (&column == &schedule_columns().front()) print(text, " %8s", "+-");
  }
  text += '\n';
  for (const ScheduleRow& row : report.rows) {
    print(text, "%-12s %5zu %-18s", row.trace.c_str(), row.sessions,
          std::string(policy_name(row.policy)).c_str());
    for (const Column& column : schedule_columns()) {
      const auto values = figures(row.runs, column);
      print(text, " %10.4g", median_of(values));
      if (&column == &schedule_columns().front()) print(text, " %8.2g", deviation_of(values));
    }
    text += '\n';
  }
  if (!report.fleet.empty()) {
    print(text, "\n%-12s %6s %7s %-14s %12s %8s %12s %11s %7s %12s\n", "trace", "n", "devices",
          "placement", "to 5% mean", "+-", "to 5% p95", "queue p95", "load +-", "a device has");
  }
  for (const FleetRow& row : report.fleet) {
    const auto runs = scores_of(row);
    const auto& columns = schedule_columns();
    print(text, "%-12s %6zu %7zu %-14s %12.4g %8.2g %12.4g %11.4g %7.3f %5zu..%zu\n",
          row.trace.c_str(), row.sessions, row.devices,
          std::string(placement_name(row.placement)).c_str(), median_of(figures(runs, columns[0])),
          deviation_of(figures(runs, columns[0])), median_of(figures(runs, columns[1])),
          median_of(figures(runs, columns[7])), row.runs.front().load_deviation,
          row.runs.front().fewest, row.runs.front().most);
  }
  if (!report.sharing.empty()) text += '\n';
  for (const SharingRow& row : report.sharing) {
    print(text, "%zu resting sessions: %.2f +- %.2f %% of the samples of one alone are lost\n",
          row.sessions, 100 * median_of(row.lost), 100 * deviation_of(row.lost));
  }
  if (!report.decisions.empty()) text += '\n';
  for (const DecisionTime& each : report.decisions) {
    std::vector<double> us = each.seconds;
    for (double& value : us) value *= 1e6;
    print(text, "a decision of %-18s at %4zu sessions: %6.2f +- %.2f us\n",
          std::string(policy_name(each.policy)).c_str(), each.sessions, median_of(us),
          deviation_of(us));
  }
  return text;
}

std::string schedule_csv(const ScheduleReport& report) {
  std::string text = "how,device,trace,sessions,devices,policy,placement";
  for (const Column& column : schedule_columns()) {
    print(text, ",%s %s,%s spread", column.name, column.unit, column.name);
  }
  text += '\n';
  const auto line = [&](const std::string& head, const std::vector<Scores>& runs) {
    text += report.how + ",\"" + report.device + "\"," + head;
    for (const Column& column : schedule_columns()) {
      const auto values = figures(runs, column);
      print(text, ",%.6g,%.3g", median_of(values), deviation_of(values));
    }
    text += '\n';
  };
  for (const ScheduleRow& row : report.rows) {
    line(row.trace + "," + std::to_string(row.sessions) + ",1," +
             std::string(policy_name(row.policy)) + ",",
         row.runs);
  }
  for (const FleetRow& row : report.fleet) {
    line(row.trace + "," + std::to_string(row.sessions) + "," + std::to_string(row.devices) + "," +
             std::string(policy_name(PolicyKind::kMarginalGain)) + "," +
             std::string(placement_name(row.placement)),
         scores_of(row));
  }
  return text;
}

std::string schedule_json(const ScheduleReport& report) {
  Json json{{"bench", "schedule"},
            {"how", report.how},
            {"device", report.device},
            {"seconds", report.seconds},
            {"costs", Json::parse(device_model_json(report.model))},
            {"rows", Json::array()},
            {"fleet", Json::array()},
            {"sharing", Json::array()},
            {"decisions", Json::array()}};
  for (const ScheduleRow& row : report.rows) {
    json["rows"].push_back({{"trace", row.trace},
                            {"sessions", row.sessions},
                            {"policy", policy_name(row.policy)},
                            {"runs", row.runs.size()},
                            {"pictures_waited_for", row.runs.front().inputs},
                            {"figures", json_of(row.runs)}});
  }
  for (const FleetRow& row : report.fleet) {
    json["fleet"].push_back({{"trace", row.trace},
                             {"sessions", row.sessions},
                             {"devices", row.devices},
                             {"placement", placement_name(row.placement)},
                             {"fewest_of_a_device", row.runs.front().fewest},
                             {"most_of_a_device", row.runs.front().most},
                             {"load_deviation", row.runs.front().load_deviation},
                             {"simulated_in_seconds", row.runs.front().seconds},
                             {"figures", json_of(scores_of(row))}});
  }
  for (const SharingRow& row : report.sharing) {
    json["sharing"].push_back({{"sessions", row.sessions},
                               {"lost", median_of(row.lost)},
                               {"spread", deviation_of(row.lost)}});
  }
  for (const DecisionTime& each : report.decisions) {
    json["decisions"].push_back({{"policy", policy_name(each.policy)},
                                 {"sessions", each.sessions},
                                 {"seconds", median_of(each.seconds)},
                                 {"spread", deviation_of(each.seconds)}});
  }
  return json.dump(1) + "\n";
}

DecisionTime measure_decision(PolicyKind policy, std::size_t sessions, unsigned repetitions) {
  constexpr int kDecisions = 2000;
  std::mt19937_64 random(1);
  DecisionTime time{policy, sessions, {}};
  const auto asked = make_policy(policy);
  for (unsigned i = 0; i <= repetitions; ++i) {
    const std::vector<SessionView> views = random_views(sessions, random);
    std::size_t quanta = 0;
    const auto start = Clock::now();
    for (int n = 0; n < kDecisions; ++n) quanta += asked->next(views).size();
    const double seconds = seconds_since(start);
    // The first repetition is a warm-up. Testing `quanta` keeps the compiler from removing the
    // decisions.
    if (i > 0 && quanta > 0) time.seconds.push_back(seconds / kDecisions);
  }
  return time;
}

}  // namespace diaphane::render::bench
