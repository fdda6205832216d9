#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string_view>

#include "common/sandbox/sandbox.h"
#include "ingest/dicom/scan.h"
#include "ingest/pipeline/report.h"

namespace diaphane::ingest {

/// The internal argument that makes this program a child ("diaphane-ingestd build-series ...").
inline constexpr const char* kChildWord = "build-series";

/// Exit codes of a child that gives no verdict. The first three are as in sysexits.h. All but the
/// last are temporary conditions, so the upload is kept.
inline constexpr int kChildNoSandbox = 70;
/// An allocation failed below the child's own limit, so the machine has too little memory.
inline constexpr int kChildNoMemory = 71;
inline constexpr int kChildDiskFails = 74;  ///< cannot read the input or write the output
inline constexpr int kChildNoRoom = 75;     ///< the disk is full or would become full
inline constexpr int kChildTooLarge = 76;   ///< the volume is left to another worker
inline constexpr int kChildBadReport = 77;  ///< the report would exceed its limit

/// Limits on the bytes of a volume, checked as soon as its size is known and before any of it is
/// decoded or written.
struct BuildBounds {
  static constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t quota_left = kNone;   ///< more is refused as "over_quota"
  std::uint64_t room_bytes = kNone;   ///< more gives kChildNoRoom
  std::uint64_t light_bytes = kNone;  ///< more gives kChildTooLarge
};

/// Sent by a child to kChildReport before it reads any of its input. JSON parsers ignore it as
/// white space.
inline constexpr char kChildBegins = '\n';

/// Enters the sandbox, reports that the child begins, and runs `work`, which fills a verdict and
/// returns an exit code. Returns the exit code of the child.
int run_in_sandbox(const SandboxLimits& sandbox, const char* refusal_for_memory,
                   const std::function<int(Verdict&)>& work);

/// Runs as the child: drops all privileges that it does not need, reads the upload from
/// kChildInput, writes voxels to kChildOutput and a report to kChildReport. Returns the exit code,
/// which is 0 also for a refusal.
int run_child_main(const dicom::ScanLimits& limits, const BuildBounds& bounds,
                   const SandboxLimits& sandbox);

/// Writes the voxels of a measured volume and then its encoded labels (volume/labels.h) to
/// kChildOutput. Returns the child's exit code, or 0.
int write_output(const volume::Volume& volume);
/// Writes bytes to kChildOutput. Returns the child's exit code, or 0.
int write_output(std::string_view bytes);
/// Fills the verdict of a child that has written something about a stored scan, whose header this
/// is. Returns the child's exit code, 0.
int succeed(volume::Header scan, Verdict& verdict);
/// Sends the report to kChildReport and returns the child's exit code.
int send_report(const Verdict& verdict);

}  // namespace diaphane::ingest
