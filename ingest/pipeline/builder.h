#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "ingest/dicom/scan.h"
#include "ingest/pipeline/report.h"
#include "ingest/pipeline/sandbox.h"
#include "volume/region.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// What came of reading one upload. At most one of the flags is set; with one, there is no verdict.
struct Build {
  Verdict verdict;
  volume::Volume volume;   ///< with verdict.ready, measured
  bool stopped = false;    ///< `go_on` said no
  bool killed = false;     ///< somebody, probably the kernel for want of memory, killed the child
  bool too_large = false;  ///< for BuildBounds::light_bytes
  double seconds = 0;
  std::uint64_t peak_bytes = 0;  ///< of the child
};

/// An upload, and what its volume may take. A volume that may not be built is never written.
struct UploadInput {
  std::string path;
  std::optional<std::uint64_t> quota_left;  ///< bytes; a larger volume is refused ("over_quota")
};

/// A stored volume that is to be cut (docs/contracts.md, "Anonymising").
struct CutInput {
  std::string volume_directory;
  volume::Header header;  ///< as it is stored there
  volume::Region region;
};

/// Makes a volume of an upload, or what is to be kept of a stored one, somewhere safe.
class Builder {
 public:
  using GoOn = std::function<bool()>;
  virtual ~Builder() = default;
  /// Never fails because of what is in the file: that is a refusal. An error is a condition that
  /// passes: kTooLarge for a full disk, kOutOfMemory, kUnavailable and kInternal for the rest.
  virtual Result<Build> build(const UploadInput& upload, const GoOn& go_on) = 0;
  /// What is left of a stored volume, which is not touched. A refusal: nothing would be left.
  virtual Result<Build> cut(const CutInput& input, const GoOn& go_on) = 0;
};

/// By a child process in a sandbox (child.h), one per upload. A child that crashes or takes too
/// long is a refusal. Its exit codes for conditions that pass are errors, and a child that was
/// killed gives no verdict.
class SandboxBuilder final : public Builder {
 public:
  struct Options {
    std::string program;             ///< this program, to be started as the child
    std::string scratch_dir;         ///< for unnamed files with voxels
    std::string volume_dir;          ///< where the volume is kept afterwards
    std::uint64_t reserve_mb = 256;  ///< of both disks, stays free
    std::uint64_t light_mb = 0;      ///< larger volumes are left to another worker; 0: none is
    std::uint32_t time_limit_s = 300;
    std::uint64_t memory_limit_mb = 6144;
    std::uint64_t quota_mb = 2048;  ///< the largest volume
  };
  explicit SandboxBuilder(Options options) : options_(std::move(options)) {}
  Result<Build> build(const UploadInput& upload, const GoOn& go_on) override;
  Result<Build> cut(const CutInput& input, const GoOn& go_on) override;

 private:
  Result<Build> run(int input, const char* word, std::vector<std::string> more, const GoOn& go_on);
  std::uint64_t room_bytes() const;
  Options options_;
};

/// The child's side of the options above: `arguments` as SandboxBuilder passes them.
int run_child_with(const std::vector<std::string>& arguments);
int run_cut_child_with(const std::vector<std::string>& arguments);

}  // namespace diaphane::ingest
