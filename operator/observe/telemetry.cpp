#include "operator/observe/telemetry.h"

#include <algorithm>
#include <cstdlib>
#include <set>
#include <utility>

#include "operator/observe/fleets_script.h"
#include "operator/plan/plan.h"

namespace diaphane::fleet {
namespace {

using api::redis::Reply;

double number(const std::string& text) { return std::strtod(text.c_str(), nullptr); }

struct Owner {
  std::string fleet, uid;
  std::int64_t epoch = 0;
};

std::optional<Owner> owner_of(const std::string& text) {
  const auto first = text.find('/');
  const auto last = text.rfind('/');
  if (first == std::string::npos || last == first) return std::nullopt;
  return Owner{text.substr(0, first), text.substr(first + 1, last - first - 1),
               std::strtoll(text.c_str() + last + 1, nullptr, 10)};
}

}  // namespace

Reading read_telemetry(const Reply& reply, const std::vector<std::string>& fleets, Seconds now) {
  Reading reading;
  if (reply.list.size() != 4) return reading;
  const double theirs = number(reply.at(0));
  const auto ours = [&](double ms) { return now - (theirs - ms) / 1000; };
  for (std::size_t i = 0; i < fleets.size(); ++i) {
    Demand demand;
    demand.fleet = fleets[i];
    demand.refused = static_cast<int>(number(reply.list[1].at(i)));
    demand.last_used = ours(number(reply.list[2].at(i)));
    demand.sampled = now;
    reading.demand.push_back(std::move(demand));
  }
  for (const Reply& one : reply.list[3].list) {
    const auto owner = owner_of(one.at(0));
    if (!owner) continue;
    Telemetry sample;
    sample.worker_uid = owner->uid;
    sample.epoch = owner->epoch;
    sample.sampled = now - number(one.at(1)) / 1000;
    sample.busy = number(one.at(2));
    sample.memory = number(one.at(3));
    sample.sessions = static_cast<int>(number(one.at(4)));
    sample.reserved = std::max(0, static_cast<int>(number(one.at(5))) - sample.sessions);
    sample.slots = static_cast<int>(number(one.at(6)));
    sample.error = number(one.at(7));
    sample.draining = one.at(8) == "1";
    sample.idle_since = ours(number(one.at(9)));
    for (Demand& demand : reading.demand) {
      if (demand.fleet != owner->fleet) continue;
      demand.used += sample.sessions;
      demand.reserved += sample.reserved;
    }
    reading.telemetry.push_back(std::move(sample));
  }
  return reading;
}

void TelemetryBook::note(Reading reading, Seconds now) {
  const std::lock_guard lock(mutex_);
  if (std::exchange(gap_, false) || now - listened_until_ > kHeartbeat) listening_since_ = now;
  listened_until_ = now;
  for (Telemetry& sample : reading.telemetry) {
    auto key = std::make_pair(sample.worker_uid, sample.epoch);
    Telemetry& known = samples_[std::move(key)];
    if (sample.sampled >= known.sampled) known = std::move(sample);
  }
  demand_ = std::move(reading.demand);
}

void TelemetryBook::missed() {
  const std::lock_guard lock(mutex_);
  gap_ = true;
}

void TelemetryBook::fill(World& world) {
  const std::lock_guard lock(mutex_);
  std::set<std::string_view> there;
  for (const Worker& worker : world.workers) there.insert(worker.uid);
  // Of workers that a list left out for once the next sample comes within a second.
  std::erase_if(samples_, [&](const auto& one) { return !there.contains(one.first.first); });
  world.telemetry.reserve(samples_.size());
  for (const auto& [key, sample] : samples_) world.telemetry.push_back(sample);
  world.demand = demand_;
  world.listening_since = listened_until_ == 0 ? world.now : listening_since_;
  world.listened_until = listened_until_ == 0 ? world.now : listened_until_;
}

Result<Reply> ask_fleets(api::redis::Client& redis, const std::vector<std::string>& fleets,
                         const std::vector<Draining>& draining) {
  const std::string count = std::to_string(fleets.size());
  api::redis::Arguments arguments{count};
  for (const std::string& fleet : fleets) arguments.emplace_back(fleet);
  for (const Draining& one : draining) {
    arguments.emplace_back(one.worker);
    arguments.emplace_back(one.owner);
  }
  return redis.run(api::redis::kFleets, arguments);
}

}  // namespace diaphane::fleet
