#include "ingest/dicom/phases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "ingest/dicom/classify.h"

namespace diaphane::dicom {
namespace {

using Indices = std::vector<std::size_t>;

/// For each slice, the number that each distinction gives it.
using Keys = std::vector<std::array<std::optional<double>, kDistinctions>>;

constexpr std::size_t index_of(Distinction by) { return static_cast<std::size_t>(by); }

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += word + "\\";
  return text;
}

Keys distinctions_of(const std::vector<Slice>& slices) {
  std::map<std::string, double> types;  // numbered in alphabetical order: "M" before "P"
  for (const Slice& slice : slices) types.emplace(joined(slice.image_type), 0);
  double number = 0;
  for (auto& [type, value] : types) value = number++;
  Keys keys;
  for (const Slice& slice : slices) {
    auto& key = keys.emplace_back(slice.moment);
    key[index_of(Distinction::kImageType)] = types[joined(slice.image_type)];
    // Frames of a file follow one another, and so do files.
    constexpr double kFramesPerInstance = 1e5;
    key[index_of(Distinction::kInstance)] =
        slice.moment[index_of(Distinction::kInstance)].value_or(0) * kFramesPerInstance +
        static_cast<double>(slice.frame);
  }
  return keys;
}

/// Returns whether all slices have this number, and it differs within each place.
bool distinguishes(const std::vector<Indices>& places, const Keys& keys, std::size_t by) {
  return std::ranges::all_of(places, [&](const Indices& place) {
    const auto same = [&](std::size_t i) { return keys[i][by] == keys[place.front()][by]; };
    return std::ranges::all_of(place, [&](std::size_t i) { return keys[i][by].has_value(); }) &&
           (place.size() == 1 || !std::ranges::all_of(place, same));
  });
}

/// The slices of phases by place. A phase may lack places.
using Grid = std::vector<std::vector<std::optional<std::size_t>>>;

/// Assigns the n-th slice of each place to the n-th phase.
Grid by_rank(const std::vector<Indices>& places) {
  Grid grid(places.front().size());
  for (auto& phase : grid) {
    for (const Indices& place : places) phase.emplace_back(place[&phase - grid.data()]);
  }
  return grid;
}

/// Assigns slices with the same number to a phase. Returns an empty grid if that is ambiguous.
Grid by_value(const std::vector<Indices>& places, const Keys& keys, std::size_t by) {
  std::map<double, std::vector<std::optional<std::size_t>>> phases;
  std::size_t most = 0;
  for (std::size_t p = 0; p < places.size(); ++p) {
    most = std::max(most, places[p].size());
    for (const std::size_t slice : places[p]) {
      auto& phase = phases[keys[slice][by].value_or(0)];
      phase.resize(places.size());
      if (phase[p]) return {};
      phase[p] = slice;
    }
  }
  // A place without gaps has all values. Otherwise, the values differ from place to place.
  if (phases.size() != most) return {};
  Grid grid;
  for (auto& [value, phase] : phases) grid.push_back(std::move(phase));
  return grid;
}

/// The first and one past the last place of a phase, or an empty range if it has gaps.
std::pair<std::size_t, std::size_t> range_of(const std::vector<std::optional<std::size_t>>& phase) {
  const auto has = [](const auto& slice) { return slice.has_value(); };
  const auto first = std::ranges::find_if(phase, has);
  const auto last = std::find_if_not(first, phase.end(), has);
  if (std::any_of(last, phase.end(), has)) return {0, 0};
  return {first - phase.begin(), last - phase.begin()};
}

/// Leaves out phases until the others have most places in common, and keeps those places.
void keep_complete(Grid& grid, std::size_t places, PhasePlan& plan) {
  std::vector<std::pair<std::size_t, std::size_t>> ranges;
  for (const auto& phase : grid) ranges.push_back(range_of(phase));
  const auto length = [&](std::size_t i) { return ranges[i].second - ranges[i].first; };
  std::size_t low = 0, high = 0;
  while (!grid.empty()) {
    low = std::ranges::max(ranges, {}, &std::pair<std::size_t, std::size_t>::first).first;
    high = std::ranges::min(ranges, {}, &std::pair<std::size_t, std::size_t>::second).second;
    if (static_cast<double>(high) >=
        static_cast<double>(low) + kLeastCommon * static_cast<double>(places))
      break;
    std::size_t shortest = 0;
    for (std::size_t i = 1; i < grid.size(); ++i) {
      if (length(i) < length(shortest)) shortest = i;
    }
    grid.erase(grid.begin() + static_cast<std::ptrdiff_t>(shortest));
    ranges.erase(ranges.begin() + static_cast<std::ptrdiff_t>(shortest));
    ++plan.incomplete;
  }
  for (std::size_t i = 0; i < grid.size(); ++i) {
    plan.uncommon += length(i) - (high - low);
    Indices& phase = plan.slices.emplace_back();
    for (std::size_t p = low; p < high; ++p) phase.push_back(*grid[i][p]);
  }
}

/// Returns the median, which a slice that was acquired again does not change.
double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

volume::PhaseKind kind_of(Distinction by) {
  switch (by) {
    case Distinction::kBValue:
      return volume::PhaseKind::kBValue;
    case Distinction::kEchoTime:
      return volume::PhaseKind::kEcho;
    case Distinction::kCycle:
      return volume::PhaseKind::kCycle;
    case Distinction::kTriggerTime:
    case Distinction::kTimeOffset:
      return volume::PhaseKind::kTime;
    default:
      return volume::PhaseKind::kIndex;
  }
}

void describe(const Keys& keys, Distinction by, PhasePlan& plan) {
  const volume::PhaseKind kind = kind_of(by);
  for (const Indices& phase : plan.slices) {
    std::vector<double> values;
    for (const std::size_t slice : phase) values.push_back(keys[slice][index_of(by)].value_or(0));
    double value = kind == volume::PhaseKind::kIndex ? static_cast<double>(plan.phases.size())
                                                     : median(std::move(values));
    if (kind == volume::PhaseKind::kTime && !plan.phases.empty()) value -= plan.phases[0].value;
    plan.phases.push_back({kind, value});
  }
  if (kind == volume::PhaseKind::kTime && !plan.phases.empty()) plan.phases[0].value = 0;
}

PhasePlan no_phases(const char* code, std::string text) {
  PhasePlan plan;
  plan.code = code;
  plan.text = std::move(text);
  return plan;
}

PhasePlan incomplete() {
  return no_phases("incomplete_phases",
                   "This series contains several scans of the same region, but slices are missing "
                   "from most of them. Try copying the files from the disc again.");
}

/// Returns whether all slices of a place lie on one another.
bool is_aligned(const std::vector<Slice>& slices, const Indices& place, double pixel) {
  const Vec3& first = *slices[place.front()].position;
  return std::ranges::all_of(place, [&](std::size_t i) {
    const Vec3 offset = minus(*slices[i].position, first);
    return std::sqrt(dot(offset, offset)) <= std::max(2 * kJitterMm, 0.1 * pixel);
  });
}

}  // namespace

std::vector<Indices> places_of(const std::vector<Slice>& slices, const Indices& kept,
                               const Axes& axes) {
  std::vector<std::pair<double, std::size_t>> along;
  for (const std::size_t i : kept) along.emplace_back(dot(*slices[i].position, axes.normal), i);
  std::sort(along.begin(), along.end());
  std::vector<Indices> places;
  for (std::size_t k = 0; k < along.size(); ++k) {
    if (k == 0 || along[k].first - along[k - 1].first > kJitterMm) places.emplace_back();
    places.back().push_back(along[k].second);
  }
  return places;
}

PhasePlan split_phases(const std::vector<Slice>& slices, const std::vector<Indices>& given,
                       double pixel) {
  std::vector<Indices> places = given;
  for (const Indices& place : places) {
    if (!is_aligned(slices, place, pixel)) {
      return no_phases("shifted_slices", "Some slices are shifted sideways.");
    }
  }
  const Keys keys = distinctions_of(slices);
  std::size_t by = 0;
  while (by < index_of(Distinction::kInstance) && !distinguishes(places, keys, by)) ++by;
  for (Indices& place : places) {
    std::sort(place.begin(), place.end(), [&](std::size_t a, std::size_t b) {
      if (keys[a][by] != keys[b][by]) return keys[a][by] < keys[b][by];
      return std::pair(keys[a], a) < std::pair(keys[b], b);
    });
  }
  const bool equal = std::ranges::all_of(
      places, [&](const Indices& place) { return place.size() == places.front().size(); });
  Grid grid = equal ? by_rank(places) : by_value(places, keys, by);
  if (grid.empty()) return incomplete();
  PhasePlan plan;
  const std::size_t all = grid.size();
  keep_complete(grid, places.size(), plan);
  if (static_cast<double>(plan.slices.size()) < kLeastComplete * static_cast<double>(all)) {
    return incomplete();
  }
  describe(keys, static_cast<Distinction>(by), plan);
  return plan;
}

}  // namespace diaphane::dicom
