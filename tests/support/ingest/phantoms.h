#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "volume/volume.h"

namespace diaphane::ingest {

/// A synthetic scan with a known answer, for tests and the benchmark.
struct Phantom {
  std::string name;
  volume::Volume volume;
  std::vector<std::uint8_t> truth;  ///< per voxel: 0 air, 1 body, 2 support
};

std::vector<std::string> phantom_names();
/// Phantoms of the size of clinical scans, to measure times.
std::vector<std::string> large_phantom_names();
/// Precondition: `name` is one of phantom_names() or large_phantom_names().
Phantom make_phantom(const std::string& name);

/// The share of the truth that a labelling keeps (body) and hides (support). 1 if there is none.
struct Agreement {
  double kept = 1, hidden = 1;
};
Agreement agreement(const Phantom& phantom, const std::vector<std::uint8_t>& labels);

}  // namespace diaphane::ingest
