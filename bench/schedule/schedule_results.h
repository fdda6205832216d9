#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/schedule/simulation.h"

namespace diaphane::render::bench {

/// Results of one kind and size of trace under one policy, with one run per seed.
struct ScheduleRow {
  std::string trace;
  std::size_t sessions = 0;
  PolicyKind policy = PolicyKind::kMarginalGain;
  std::vector<Scores> runs;
};

struct FleetRow {
  std::size_t sessions = 0, devices = 0;
  std::string trace;
  Placement placement = Placement::kSummedError;
  std::vector<FleetRun> runs;
};

/// The time that a policy takes for a decision.
struct DecisionTime {
  PolicyKind policy = PolicyKind::kMarginalGain;
  std::size_t sessions = 0;
  std::vector<double> seconds;  ///< mean of each repetition
};

/// What a device loses with several resting sessions, compared with one alone with long quanta.
struct SharingRow {
  std::size_t sessions = 0;
  std::vector<double> lost;  ///< share, per repetition
};

struct ScheduleReport {
  std::string how;  ///< "simulated" or "real"
  std::string device;
  double seconds = 0;  ///< length of a trace
  std::vector<ScheduleRow> rows;
  std::vector<FleetRow> fleet;
  std::vector<SharingRow> sharing;
  std::vector<DecisionTime> decisions;
  DeviceModel model;
};

/// A column of the tables.
struct Column {
  const char* name;
  const char* unit;
  double scale;
  double Scores::*figure;
};
const std::vector<Column>& schedule_columns();

std::string schedule_text(const ScheduleReport& report);
std::string schedule_csv(const ScheduleReport& report);
std::string schedule_json(const ScheduleReport& report);

/// Measures decisions among `sessions` random views, of which most would gain. Returns
/// `repetitions` means over some thousand decisions.
DecisionTime measure_decision(PolicyKind policy, std::size_t sessions, unsigned repetitions);

}  // namespace diaphane::render::bench
