#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "volume/labels.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// A synthetic CT in Hounsfield units whose parts are known.
struct PartPhantom {
  volume::Volume volume;
  std::vector<volume::Label> truth;  ///< per voxel; matter of no part is kBody
};

struct ChestOptions {
  int blood = 45;     ///< Hounsfield units; 320 with contrast medium
  int marrow = 170;   ///< of the spine
  double noise = 25;  ///< standard deviation
  std::array<double, 3> spacing{1.1, 1.1, 1.5};
  std::array<double, 9> direction{1, 0, 0, 0, 1, 0, 0, 0, 1};
};
/// A chest with spine, ribs, two lungs with their vessels, windpipe, main bronchi, heart and aorta.
PartPhantom chest(const ChestOptions& options = {});

/// An abdomen with gas and stool in the bowel, and a spine that the bowel touches. `bowel`: value
/// of what was swallowed.
PartPhantom abdomen(int bowel = 30);

/// Returns 2 |A ∩ B| / (|A| + |B|) of the voxels with a label and those that should have it.
double dice(const PartPhantom& phantom, const volume::Labels& labels, volume::Label label);

}  // namespace diaphane::ingest
