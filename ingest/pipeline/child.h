#pragma once

#include <cstddef>

#include "ingest/dicom/scan.h"
#include "ingest/pipeline/sandbox.h"

namespace diaphane::ingest {

/// The word that makes this program a child ("diaphane-ingestd build-series ..."): not for people.
inline constexpr const char* kChildWord = "build-series";

/// The child: gives up everything it does not need, reads the upload behind kChildInput, writes
/// voxels behind kChildOutput and a report behind kChildReport. The exit code; 0 also for a
/// refusal.
int run_child_main(const dicom::ScanLimits& limits, const SandboxLimits& sandbox);

/// To one of a child's descriptors, whole.
bool write_all(int fd, const char* data, std::size_t bytes);

}  // namespace diaphane::ingest
