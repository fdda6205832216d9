#include "renderd/session/volume_facts.h"

#include <utility>

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

VolumeFacts KeptFacts::of(const DeviceVolume& volume) const {
  const std::scoped_lock lock(mutex_);
  const auto found = entries_.find(&volume);
  return found == entries_.end() ? VolumeFacts() : found->second.facts;
}

}  // namespace diaphane::render
