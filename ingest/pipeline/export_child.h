#pragma once

#include <string>

#include "common/sandbox/sandbox.h"

namespace diaphane::ingest {

/// The internal argument that makes this program the child that exports a scan.
inline constexpr const char* kExportChildWord = "export-scan";

/// Runs as the child: drops all privileges that it does not need, reads the voxels of a stored
/// volume from kChildInput (or its labels, for the surface of one), writes the export to
/// kChildOutput and a report to kChildReport. `header` is the text of volume.json, and `order`
/// comes from to_text() (export_jobs.h). Returns the exit code, which is 0 also for a refusal.
int run_export_child_main(const std::string& header, const std::string& order,
                          const SandboxLimits& sandbox);

}  // namespace diaphane::ingest
