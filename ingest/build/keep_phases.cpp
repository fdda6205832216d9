#include "ingest/build/keep_phases.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

namespace diaphane::ingest {
namespace {

std::optional<std::uint32_t> whole_number(std::string_view text) {
  std::uint32_t value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

Result<PhaseChoice> parse_phases(const std::string& phases, const std::string& every) {
  PhaseChoice choice;
  if (!phases.empty() && !every.empty())
    return fail(ErrorCode::kInvalid, "--phases and --every cannot be combined");
  if (!every.empty()) {
    const auto step = whole_number(every);
    if (!step || *step == 0)
      return fail(ErrorCode::kInvalid, "--every: must be a whole number above 0");
    choice.every = *step;
  }
  for (std::size_t at = 0; !phases.empty() && at <= phases.size();) {
    const std::size_t comma = std::min(phases.find(',', at), phases.size());
    const auto phase = whole_number(std::string_view(phases).substr(at, comma - at));
    if (!phase)
      return fail(ErrorCode::kInvalid, "--phases: must be whole numbers, separated by commas");
    choice.listed.push_back(*phase);
    at = comma + 1;
  }
  return choice;
}

Result<std::vector<std::uint32_t>> chosen_phases(const PhaseChoice& choice, std::uint32_t count) {
  std::vector<std::uint32_t> kept = choice.listed;
  for (std::uint64_t phase = 0; choice.listed.empty() && phase < count; phase += choice.every)
    kept.push_back(static_cast<std::uint32_t>(phase));
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  if (kept.back() >= count) {
    return fail(ErrorCode::kInvalid, "there is no phase " + std::to_string(kept.back()) +
                                         "; the last one is " + std::to_string(count - 1));
  }
  return kept;
}

void keep_phases(volume::Volume& volume, std::span<const std::uint32_t> kept) {
  volume::Header& header = volume.header;
  if (kept.size() == header.phase_count()) return;
  const auto size = static_cast<std::ptrdiff_t>(header.voxel_count());
  std::vector<volume::Phase> phases;
  auto to = volume.voxels.begin();
  // In ascending order, no phase is overwritten before it is moved.
  for (const std::uint32_t phase : kept) {
    phases.push_back(header.phases[phase]);
    const auto from = volume.voxels.begin() + phase * size;
    if (from != to) std::copy(from, from + size, to);
    to += size;
  }
  volume.voxels.erase(to, volume.voxels.end());
  volume.voxels.shrink_to_fit();
  header.phases = phases.size() > 1 ? std::move(phases) : std::vector<volume::Phase>();
  volume::measure(volume);
}

}  // namespace diaphane::ingest
