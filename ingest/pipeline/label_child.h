#pragma once

#include <string>

#include "common/sandbox/sandbox.h"

namespace diaphane::ingest {

/// The internal argument that makes this program the child that places labels on a scan's grid.
inline constexpr const char* kLabelChildWord = "place-labels";

/// Runs as the child: drops all privileges that it does not need, reads an upload with one file of
/// labels from kChildInput, writes the encoded label set to kChildOutput and a report to
/// kChildReport. `header` is the text of the scan's volume.json. Returns the exit code, which is 0
/// also for a refusal.
int run_label_child_main(const std::string& header, const SandboxLimits& sandbox);

}  // namespace diaphane::ingest
