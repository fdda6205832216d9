#include "renderd/session/volume_stats.h"

#include <array>
#include <utility>
#include <vector>

#include "renderd/scene/contrast_agent.h"
#include "renderd/session/histogram.h"
#include "volume/labels.h"

namespace diaphane::render {

namespace {

diaphane::v1::Labels labels_of(const volume::Volume& volume) {
  std::array<std::uint64_t, volume::kMostLabels + 1> voxels{};
  for (const std::uint8_t label : volume.label_set.labels.voxels) ++voxels[label];
  const auto& spacing = volume.header.spacing;
  diaphane::v1::Labels labels;
  std::size_t value = 0;
  for (const volume::LabelEntry& entry : volume.label_set.table) {
    const auto& [red, green, blue] = entry.colour;
    auto& label = *labels.add_labels();
    label.set_number(entry.number);
    label.set_name(entry.name);
    label.set_colour(std::uint32_t{red} << 16 | std::uint32_t{green} << 8 | blue);
    label.set_volume(static_cast<double>(voxels[++value]) * spacing[0] * spacing[1] * spacing[2]);
  }
  return labels;
}

}  // namespace

VolumeStats stats_of(const volume::Volume& volume) {
  return {histogram_of(volume),
          coarse_of(volume),
          volume::has_support(volume),
          visible_part(volume),
          shows_contrast_agent(volume),
          brain_of(volume),
          labels_of(volume)};
}

void VolumeStatsCache::add(const std::shared_ptr<const DeviceVolume>& volume, VolumeStats stats) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(entries_, [](const auto& entry) { return entry.second.volume.expired(); });
  entries_[volume.get()] = {volume, std::move(stats)};
}

void VolumeStatsCache::forget_expired() {
  std::vector<VolumeStats> expired;  // freed outside the lock
  const std::scoped_lock lock(mutex_);
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    if (!entry->second.volume.expired()) {
      ++entry;
      continue;
    }
    expired.push_back(std::move(entry->second.stats));
    entry = entries_.erase(entry);
  }
}

VolumeStats VolumeStatsCache::of(const DeviceVolume& volume) const {
  const std::scoped_lock lock(mutex_);
  const auto found = entries_.find(&volume);
  return found == entries_.end() ? VolumeStats() : found->second.stats;
}

Framing VolumeStatsCache::framing_of(const DeviceVolume& volume) const {
  return of(volume).framing.value_or(whole_box(volume.header()));
}

}  // namespace diaphane::render
