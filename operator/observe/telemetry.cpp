#include "operator/observe/telemetry.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

#include "operator/plan/plan.h"

namespace diaphane::fleet {
namespace {

/// Bounds a scan that does not end. No real number of workers fills this many pages.
constexpr int kMostPages = 100'000;

struct OwnerText {
  std::string_view fleet, uid;
  std::int64_t epoch = 0;
};

std::optional<OwnerText> owner_of(std::string_view text) {
  const auto first = text.find('/');
  const auto last = text.rfind('/');
  if (first == std::string_view::npos || last == first) return std::nullopt;
  OwnerText owner{text.substr(0, first), text.substr(first + 1, last - first - 1)};
  std::from_chars(text.data() + last + 1, text.data() + text.size(), owner.epoch);
  return owner;
}

}  // namespace

TelemetryReader::TelemetryReader(const std::vector<std::string>& fleets) {
  for (const std::string& name : fleets) reading_.demand.emplace_back().fleet = name;
}

void TelemetryReader::add(const directory::FleetPage& page, Seconds now) {
  for (std::size_t i = 0; i < std::min(reading_.demand.size(), page.demand.size()); ++i) {
    Demand& demand = reading_.demand[i];
    demand.refused = page.demand[i].refused;
    demand.last_used = now - page.demand[i].idle_s;
    demand.sampled = now;
  }
  for (const directory::WorkerReport& report : page.workers) add_worker(report, now);
}

void TelemetryReader::add_worker(const directory::WorkerReport& report, Seconds now) {
  const auto owner = owner_of(report.owner);
  if (!owner || !seen_.insert(report.owner).second) return;
  Telemetry sample;
  sample.worker_uid = owner->uid;
  sample.epoch = owner->epoch;
  sample.sampled = now - report.age_s;
  sample.busy = report.busy;
  sample.memory = report.memory;
  sample.sessions = report.sessions;
  sample.reserved = std::max(0, report.used - report.sessions);
  sample.slots = report.slots;
  sample.error = report.error;
  sample.draining = report.draining;
  sample.idle_since = now - report.idle_s;
  for (Demand& demand : reading_.demand) {
    if (demand.fleet != owner->fleet) continue;
    demand.used += sample.sessions;
    demand.reserved += sample.reserved;
  }
  reading_.telemetry.push_back(std::move(sample));
}

void TelemetryCache::note(Reading reading, Seconds now) {
  const std::lock_guard lock(mutex_);
  if (std::exchange(gap_, false) || now - listened_until_ > kHeartbeat) listening_since_ = now;
  listened_until_ = now;
  for (Telemetry& sample : reading.telemetry) {
    Telemetry& known = samples_[sample.worker_uid][sample.epoch];
    if (sample.sampled >= known.sampled) known = std::move(sample);
  }
  demand_ = std::move(reading.demand);
}

void TelemetryCache::missed() {
  const std::lock_guard lock(mutex_);
  gap_ = true;
}

void TelemetryCache::fill(ClusterState& world) {
  const std::lock_guard lock(mutex_);
  std::unordered_set<std::string_view> existing(world.workers.size());
  for (const Worker& worker : world.workers) existing.insert(worker.uid);
  // A worker that a list omits once is added again by its next sample within a second.
  std::erase_if(samples_, [&](const auto& one) { return !existing.contains(one.first); });
  // Assigns in place to reuse the memory of the elements.
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

Result<Reading> ask_fleets(directory::Client& redis, const std::vector<std::string>& fleets,
                           const std::vector<directory::DrainRequest>& draining,
                           const std::function<Seconds()>& now) {
  TelemetryReader reader(fleets);
  std::string cursor(directory::kFirstPage);
  for (int pages = 0; pages < kMostPages; ++pages) {
    static const std::vector<directory::DrainRequest> kNone;
    const auto page = directory::read_fleets(redis, cursor, fleets, pages == 0 ? draining : kNone);
    if (!page) return tl::unexpected(page.error());
    reader.add(*page, now());
    if (page->next == directory::kFirstPage) return reader.take();
    cursor = page->next;
  }
  return fail(ErrorCode::kInternal, "fleets.lua returned too many pages");
}

}  // namespace diaphane::fleet
