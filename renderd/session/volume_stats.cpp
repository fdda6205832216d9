#include "renderd/session/volume_stats.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "renderd/scene/contrast_agent.h"
#include "renderd/session/histogram.h"
#include "volume/labels.h"

namespace diaphane::render {

namespace {

/// The voxel values of one label.
struct LabelValues {
  std::uint64_t voxels = 0;
  // Exact, because 2^31 voxels of 16 bits have a sum below 2^47 and a sum of squares below 2^61.
  std::int64_t sum = 0;
  std::uint64_t squares = 0;
  std::int32_t minimum = std::numeric_limits<std::int16_t>::max();
  std::int32_t maximum = std::numeric_limits<std::int16_t>::min();

  void add(std::int32_t value) {
    ++voxels;
    sum += value;
    squares += static_cast<std::uint64_t>(value * value);
    minimum = std::min(minimum, value);
    maximum = std::max(maximum, value);
  }
  double mean() const { return voxels == 0 ? 0 : double(sum) / double(voxels); }
  double deviation() const {
    if (voxels == 0) return 0;
    const long double n = static_cast<long double>(voxels), mean = sum / n;
    return double(std::sqrt(std::max(0.0L, squares / n - mean * mean)));
  }
};

diaphane::v1::Labels labels_of(const volume::Volume& volume) {
  std::array<LabelValues, volume::kMostLabels + 1> values{};
  const auto& numbers = volume.label_set.labels.voxels;
  for (std::size_t i = 0; i < numbers.size(); ++i) values.at(numbers[i]).add(volume.voxels[i]);
  const auto& spacing = volume.header.spacing;
  diaphane::v1::Labels labels;
  std::size_t value = 0;
  for (const volume::LabelEntry& entry : volume.label_set.table) {
    const auto& [red, green, blue] = entry.colour;
    auto& label = *labels.add_labels();
    const LabelValues& of = values.at(++value);
    label.set_number(entry.number);
    label.set_name(entry.name);
    label.set_colour(std::uint32_t{red} << 16 | std::uint32_t{green} << 8 | blue);
    label.set_volume(static_cast<double>(of.voxels) * spacing[0] * spacing[1] * spacing[2]);
    label.set_mean(of.mean());
    label.set_deviation(of.deviation());
    label.set_minimum(of.minimum);
    label.set_maximum(of.maximum);
  }
  return labels;
}

}  // namespace

VolumeStats stats_of(const volume::Volume& volume) {
  return {histogram_of(volume),
          nullptr,
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
