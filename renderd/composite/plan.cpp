#include "renderd/composite/plan.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace diaphane::render {
namespace {

/// Parts come in pairs of samples.
constexpr double kPair = 2;

/// Returns the number of parts in which a device delivers this many samples in one epoch. As in
/// part_due(), parts contain pairs, and each has a quarter of the samples delivered before.
double parts_for(double samples) {
  double parts = 0;
  for (double delivered = 0; delivered < samples; ++parts) {
    delivered += kPair * std::max(1.0, std::ceil(delivered / 4 / kPair));
  }
  return std::max(parts, 1.0);
}

}  // namespace

void RowCosts::learn(std::uint32_t first, std::uint32_t last, std::uint32_t height, double seconds,
                     double total_seconds) {
  if (!(seconds > 0) || !(total_seconds > 0) || first >= last || last > height) return;
  const double expected = share_of(first, last, height);
  // The clamp limits the effect of a single measurement.
  const double off = std::clamp(seconds / total_seconds / expected, 0.25, 4.0);
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const double middle = (static_cast<double>(bin) + 0.5) / kBins * height;
    if (middle < first || middle >= last) continue;
    bins_[bin] = std::clamp(bins_[bin] * std::sqrt(off), 0.02, 50.0);
  }
  const double mean = std::accumulate(bins_.begin(), bins_.end(), 0.0) / kBins;
  for (double& bin : bins_) bin /= mean;
}

double RowCosts::share_of(std::uint32_t first, std::uint32_t last, std::uint32_t height) const {
  const double total = std::accumulate(bins_.begin(), bins_.end(), 0.0);
  const double from = double(first) / height * kBins, to = double(last) / height * kBins;
  double sum = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const auto low = static_cast<double>(bin);
    sum += bins_[bin] * std::max(0.0, std::min(to, low + 1) - std::max(from, low));
  }
  return sum / total;
}

std::vector<std::optional<Share>> plan_shares(Division division, Canvas canvas,
                                              const std::vector<double>& speeds,
                                              const RowCosts& costs, std::uint64_t sequence) {
  std::vector<std::optional<Share>> shares(speeds.size());
  const auto takes_part = [&](std::size_t d) { return speeds[d] > 0; };
  if (division == Division::kAverage) {
    std::uint32_t parts = 0;
    for (std::size_t d = 0; d < speeds.size(); ++d) {
      if (takes_part(d)) shares[d] = Share{.part = parts++, .parts = 1, .sequence = sequence};
    }
    for (auto& share : shares) {
      if (share) share->parts = parts;
    }
    return shares;
  }
  const std::uint32_t units = (canvas.height + kShareRows - 1) / kShareRows;
  double left = std::accumulate(speeds.begin(), speeds.end(), 0.0);
  auto devices = static_cast<std::uint32_t>(
      std::count_if(speeds.begin(), speeds.end(), [](double s) { return s > 0; }));
  const auto row_of = [&](std::uint32_t unit) {
    return std::min(unit * kShareRows, canvas.height);
  };
  std::uint32_t first = 0;
  for (std::size_t d = 0; d < speeds.size() && first < units; ++d) {
    if (!takes_part(d)) continue;
    // The device's fraction of the remaining cost is its fraction of the remaining speed.
    const double wanted = costs.share_of(row_of(first), canvas.height, canvas.height) *
                          std::min(1.0, speeds[d] / left);
    const std::uint32_t others = --devices;
    left -= speeds[d];
    std::uint32_t last = first + 1;
    const auto cost_to = [&](std::uint32_t unit) {
      return costs.share_of(row_of(first), row_of(unit), canvas.height);
    };
    while (last < units && units - last > others &&
           wanted - cost_to(last) > cost_to(last + 1) - wanted) {
      ++last;
    }
    if (others == 0) last = units;
    shares[d] = Share{.first_row = row_of(first), .last_row = row_of(last), .sequence = sequence};
    first = last;
  }
  return shares;
}

DivisionGain predict(Division division, const DivisionInput& input) {
  const double pixels = input.canvas.pixels();
  const double speed = std::accumulate(input.speeds.begin(), input.speeds.end(), 0.0);
  const auto others = static_cast<double>(input.speeds.size() - 1);
  if (others == 0) return {input.samples * pixels / speed, 0};
  const bool average = division == Division::kAverage;
  // Pixels merged in one turn from all parts.
  const double merged = average ? others * pixels : pixels * (1 - input.speeds.front() / speed);
  const double part = others * input.part_seconds +
                      merged * (sizeof(PackedPixel) / input.bytes_per_second + input.merge_seconds);
  // With an average, each device renders pairs. With tiles, the slowest band determines the time.
  const double each = input.samples / (average ? others + 1 : 1);
  const double rendering = average ? kPair * std::ceil(each / kPair) * (others + 1) * pixels / speed
                                   : each * pixels / speed * (1 + kBandsUneven * others);
  double parts = parts_for(each);
  if (input.turn_seconds > 0) {
    // Parts are taken at the ends of turns. More parts take longer, which makes more turns, so this
    // iterates.
    double fitting = 1;
    for (int i = 0; i < 8; ++i) {
      fitting = std::max(1.0, std::round((rendering + fitting * part) / input.turn_seconds));
    }
    parts = std::min(parts, fitting);
  }
  double seconds = rendering + parts * part;
  if (average) {
    // No samples of other devices arrive during a turn of the device that shows the picture. If a
    // pair from each device exceeds the samples needed, that device alone is as fast.
    const double alone = input.samples * pixels / input.speeds.front();
    seconds = std::min(std::max(seconds, input.turn_seconds), alone);
  }
  return {seconds, parts * merged * sizeof(PackedPixel)};
}

Division choose_division(const DivisionInput& input) {
  if (input.speeds.size() < 2) return Division::kAverage;
  for (const double speed : input.speeds) {
    if (!(speed > 0)) return Division::kAverage;
  }
  // There must be at least one unit of rows per device.
  if (input.canvas.height < kShareRows * input.speeds.size()) return Division::kAverage;
  const double average = predict(Division::kAverage, input).seconds;
  const double tiles = predict(Division::kTiles, input).seconds;
  const double faster = input.before == Division::kTiles ? 1.0 : 0.9;
  return tiles < faster * average ? Division::kTiles : Division::kAverage;
}

bool part_due(const PartInput& input) {
  if (!input.room || input.held < 2) return false;
  if (input.delivered == 0) return true;
  if (input.seconds_since < 8 * input.seconds_cost) return false;
  return 4 * input.held >= input.delivered || input.seconds_since >= 0.1;
}

bool may_render(const PartInput& input) {
  return input.room || input.held < std::max<std::uint64_t>(input.delivered, 2);
}

}  // namespace diaphane::render
