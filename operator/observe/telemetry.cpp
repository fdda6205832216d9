#include "operator/observe/telemetry.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "operator/observe/fleets_script.h"
#include "operator/plan/plan.h"

namespace diaphane::fleet {
namespace {

using api::redis::Reply;

/// Of so many workers that nobody has them.
constexpr int kMostPages = 100'000;

enum Field { kOwner, kAge, kBusy, kMemory, kSessions, kUsed, kSlots, kError, kDrains, kIdle };
constexpr std::size_t kFields = kIdle + 1;

double number(std::string_view text) {
  double value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

/// 0 for what is none.
int whole(std::string_view text) {
  const double value = number(text);
  return value > 0 ? static_cast<int>(std::min(value, 1e9)) : 0;
}

struct Owner {
  std::string_view fleet, uid;
  std::int64_t epoch = 0;
};

std::optional<Owner> owner_of(std::string_view text) {
  const auto first = text.find('/');
  const auto last = text.rfind('/');
  if (first == std::string_view::npos || last == first) return std::nullopt;
  Owner owner{text.substr(0, first), text.substr(first + 1, last - first - 1)};
  std::from_chars(text.data() + last + 1, text.data() + text.size(), owner.epoch);
  return owner;
}

std::optional<std::array<std::string_view, kFields>> split(std::string_view line) {
  std::array<std::string_view, kFields> fields;
  for (std::size_t i = 0; i < kFields; ++i) {
    const auto end = line.find(' ');
    if ((end == std::string_view::npos) != (i + 1 == kFields)) return std::nullopt;
    fields[i] = line.substr(0, end);
    if (i + 1 < kFields) line.remove_prefix(end + 1);
  }
  return fields;
}

}  // namespace

TelemetryReader::TelemetryReader(const std::vector<std::string>& fleets) {
  for (const std::string& name : fleets) reading_.demand.emplace_back().fleet = name;
}

std::optional<std::string> TelemetryReader::add(const Reply& page, Seconds now) {
  if (page.list.size() != 5 || page.at(0).empty()) return std::nullopt;
  const double theirs = number(page.at(1));
  for (std::size_t i = 0; i < reading_.demand.size(); ++i) {
    Demand& demand = reading_.demand[i];
    demand.refused = whole(page.list[2].at(i));
    demand.last_used = now - (theirs - number(page.list[3].at(i))) / 1000;
    demand.sampled = now;
  }
  std::string_view lines = page.at(4);
  while (!lines.empty()) {
    const auto end = std::min(lines.find('\n'), lines.size());
    add_worker(lines.substr(0, end), theirs, now);
    lines.remove_prefix(std::min(end + 1, lines.size()));
  }
  return page.at(0);
}

void TelemetryReader::add_worker(std::string_view line, double theirs, Seconds now) {
  const auto fields = split(line);
  const auto owner = fields ? owner_of((*fields)[kOwner]) : std::nullopt;
  if (!owner || !seen_.emplace((*fields)[kOwner]).second) return;
  Telemetry sample;
  sample.worker_uid = owner->uid;
  sample.epoch = owner->epoch;
  sample.sampled = now - number((*fields)[kAge]) / 1000;
  sample.busy = number((*fields)[kBusy]);
  sample.memory = number((*fields)[kMemory]);
  sample.sessions = whole((*fields)[kSessions]);
  sample.reserved = std::max(0, whole((*fields)[kUsed]) - sample.sessions);
  sample.slots = whole((*fields)[kSlots]);
  sample.error = number((*fields)[kError]);
  sample.draining = (*fields)[kDrains] == "1";
  sample.idle_since = now - (theirs - number((*fields)[kIdle])) / 1000;
  for (Demand& demand : reading_.demand) {
    if (demand.fleet != owner->fleet) continue;
    demand.used += sample.sessions;
    demand.reserved += sample.reserved;
  }
  reading_.telemetry.push_back(std::move(sample));
}

void TelemetryBook::note(Reading reading, Seconds now) {
  const std::lock_guard lock(mutex_);
  if (std::exchange(gap_, false) || now - listened_until_ > kHeartbeat) listening_since_ = now;
  listened_until_ = now;
  for (Telemetry& sample : reading.telemetry) {
    Telemetry& known = samples_[sample.worker_uid][sample.epoch];
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
  std::unordered_set<std::string_view> there(world.workers.size());
  for (const Worker& worker : world.workers) there.insert(worker.uid);
  // Of workers that a list left out for once the next sample comes within a second.
  std::erase_if(samples_, [&](const auto& one) { return !there.contains(one.first); });
  // Assigned, not made anew: what is there has its memory already.
  std::size_t count = 0;
  for (const auto& [uid, epochs] : samples_) {
    for (const auto& [epoch, sample] : epochs) {
      if (count == world.telemetry.size()) world.telemetry.emplace_back();
      world.telemetry[count++] = sample;
    }
  }
  world.telemetry.resize(count);
  world.demand = demand_;
  world.listening_since = listened_until_ == 0 ? world.now : listening_since_;
  world.listened_until = listened_until_ == 0 ? world.now : listened_until_;
}

Result<Reading> ask_fleets(api::redis::Client& redis, const std::vector<std::string>& fleets,
                           const std::vector<Draining>& draining,
                           const std::function<Seconds()>& now) {
  const std::string count = std::to_string(fleets.size());
  std::string cursor(kFirstPage);
  api::redis::Arguments arguments{cursor, count};
  for (const std::string& fleet : fleets) arguments.emplace_back(fleet);
  const std::size_t without_draining = arguments.size();
  for (const Draining& one : draining) {
    arguments.emplace_back(one.worker);
    arguments.emplace_back(one.owner);
  }
  TelemetryReader reader(fleets);
  for (int pages = 0; pages < kMostPages; ++pages) {
    const auto page = redis.run(api::redis::kFleets, arguments);
    if (!page) return tl::unexpected(page.error());
    const auto next = reader.add(*page, now());
    if (!next) break;
    if (*next == kFirstPage) return reader.take();
    cursor = *next;
    arguments.resize(without_draining);
    arguments[0] = cursor;
  }
  return fail(ErrorCode::kInternal, "fleets.lua answers something else");
}

}  // namespace diaphane::fleet
