#include "renderd/session/volume_facts.h"

#include <utility>
#include <vector>

#include "renderd/session/histogram.h"

namespace diaphane::render {

VolumeFacts facts_of(const volume::Volume& volume) {
  return {histogram_of(volume), coarse_of(volume)};
}

void KeptFacts::add(const std::shared_ptr<const DeviceVolume>& volume, VolumeFacts facts) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(entries_, [](const auto& entry) { return entry.second.volume.expired(); });
  entries_[volume.get()] = {volume, std::move(facts)};
}

void KeptFacts::forget_expired() {
  std::vector<VolumeFacts> expired;  // freed outside the lock
  const std::scoped_lock lock(mutex_);
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    if (!entry->second.volume.expired()) {
      ++entry;
      continue;
    }
    expired.push_back(std::move(entry->second.facts));
    entry = entries_.erase(entry);
  }
}

VolumeFacts KeptFacts::of(const DeviceVolume& volume) const {
  const std::scoped_lock lock(mutex_);
  const auto found = entries_.find(&volume);
  return found == entries_.end() ? VolumeFacts() : found->second.facts;
}

}  // namespace diaphane::render
