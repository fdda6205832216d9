#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// The help of the options that parse_phases() understands.
inline constexpr const char* kPhasesHelp =
    "keep only these phases, for example 0,5,10; the first is 0";
inline constexpr const char* kEveryHelp = "keep only every Nth phase, beginning with the first";

/// Which phases to keep. All of them, if nothing is set.
struct PhaseChoice {
  std::vector<std::uint32_t> listed;
  std::uint32_t every = 1;

  bool is_all() const { return listed.empty() && every == 1; }
};

/// Parses the values of --phases and --every, of which at most one is not empty. Returns kInvalid
/// with a message about the option.
Result<PhaseChoice> parse_phases(const std::string& phases, const std::string& every);

/// Returns the numbers of the phases to keep of `count`, in ascending order. Returns kInvalid if
/// one of them does not exist.
Result<std::vector<std::uint32_t>> chosen_phases(const PhaseChoice& choice, std::uint32_t count);

/// Removes all phases of a volume that are not in `kept`, and measures it again. Precondition:
/// `kept` is a result of chosen_phases().
void keep_phases(volume::Volume& volume, std::span<const std::uint32_t> kept);

}  // namespace diaphane::ingest
