#pragma once

#include <optional>
#include <string>

#include "common/sandbox/sandbox.h"
#include "ingest/registration/register.h"

namespace diaphane::ingest {

/// The internal argument that makes this program the child that aligns two scans.
inline constexpr const char* kAlignChildWord = "align-scans";

/// Runs as the child: drops all privileges that it does not need, reads the voxels of the first
/// phase of the fixed scan from kChildInput, and after them those of the moving scan, writes the
/// alignment to kChildOutput (to_text()) and a report to kChildReport. `fixed` and `moving` are the
/// texts of volume.json. Returns the exit code, which is 0 also for a refusal.
int run_align_child_main(const std::string& fixed, const std::string& moving,
                         const SandboxLimits& sandbox);

/// Serialise an alignment for the parent process. The parent accepts only sound numbers.
std::string to_text(const RigidAlignment& found);
std::optional<RigidAlignment> alignment_of(const std::string& text);
/// Maximum length of to_text().
inline constexpr std::size_t kLongestAlignment = 4096;

}  // namespace diaphane::ingest
