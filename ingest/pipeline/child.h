#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "ingest/dicom/scan.h"
#include "ingest/pipeline/report.h"
#include "ingest/pipeline/sandbox.h"

namespace diaphane::ingest {

/// The word that makes this program a child ("diaphane-ingestd build-series ..."): not for people.
inline constexpr const char* kChildWord = "build-series";

/// Exit codes of a child that gives no verdict (the first two as in sysexits.h). All but the last
/// are conditions that pass, so the upload is kept.
inline constexpr int kChildNoSandbox = 70;
inline constexpr int kChildDiskFails = 74;  ///< the output cannot be written
inline constexpr int kChildNoRoom = 75;     ///< the disk is full, or would be
inline constexpr int kChildTooLarge = 76;   ///< the volume is left to another worker
inline constexpr int kChildBadReport = 77;  ///< its report would be longer than is allowed

/// Bytes that a volume may take. It is held against them as soon as its size is known, before any
/// of it is decoded or written.
struct BuildBounds {
  static constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t quota_left = kNone;   ///< beyond it: the refusal "over_quota"
  std::uint64_t room_bytes = kNone;   ///< beyond it: kChildNoRoom
  std::uint64_t light_bytes = kNone;  ///< beyond it: kChildTooLarge
};

/// The child: gives up everything it does not need, reads the upload behind kChildInput, writes
/// voxels behind kChildOutput and a report behind kChildReport. The exit code; 0 also for a
/// refusal.
int run_child_main(const dicom::ScanLimits& limits, const BuildBounds& bounds,
                   const SandboxLimits& sandbox);

/// Voxels to kChildOutput. False: they cannot be written, and `exit_code` says why.
bool write_output(const std::int16_t* voxels, std::size_t count, int& exit_code);
/// To kChildReport. The child's exit code.
int send_report(const Verdict& verdict);

}  // namespace diaphane::ingest
