#pragma once

#include <string>
#include <vector>

#include "ingest/pipeline/sandbox.h"

namespace diaphane::ingest {

/// The word that makes this program the child that cuts a stored volume: not for people.
inline constexpr const char* kCutChildWord = "cut-volume";

/// The child: gives up everything it does not need, reads the voxels behind kChildInput slice by
/// slice, writes what is kept behind kChildOutput and a report behind kChildReport. `header` is the
/// text of volume.json, `region` that of volume/region.h. The exit code; 0 also for a refusal.
int run_cut_child_main(const std::string& header, const std::string& region,
                       const SandboxLimits& sandbox);

}  // namespace diaphane::ingest
