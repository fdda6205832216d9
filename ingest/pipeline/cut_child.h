#pragma once

#include <string>
#include <vector>

#include "common/sandbox/sandbox.h"

namespace diaphane::ingest {

/// The internal argument that makes this program the child that cuts a stored volume.
inline constexpr const char* kCutChildWord = "cut-volume";

/// Runs as the child: drops all privileges that it does not need, reads the voxels from kChildInput
/// slice by slice, writes the kept ones to kChildOutput and a report to kChildReport. `header` is
/// the text of volume.json, `region` that of volume/region.h. Returns the exit code, which is 0
/// also for a refusal.
int run_cut_child_main(const std::string& header, const std::string& region,
                       const SandboxLimits& sandbox);

}  // namespace diaphane::ingest
