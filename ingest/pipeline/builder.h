#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "common/result.h"
#include "ingest/dicom/scan.h"
#include "ingest/pipeline/report.h"
#include "ingest/pipeline/sandbox.h"
#include "volume/region.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// What came of reading one upload.
struct Build {
  Verdict verdict;
  volume::Volume volume;  ///< with verdict.ready, measured
  bool stopped = false;   ///< `go_on` said no: no verdict
  double seconds = 0;
  std::uint64_t peak_bytes = 0;  ///< of the child
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
  /// Never fails because of what is in the file: that is a refusal. kUnavailable, kInternal: our
  /// own means.
  virtual Result<Build> build(const std::string& upload_path, const GoOn& go_on) = 0;
  /// What is left of a stored volume, which is not touched. A refusal: nothing would be left.
  virtual Result<Build> cut(const CutInput& input, const GoOn& go_on) = 0;
};

/// By a child process in a sandbox (child.h), one an upload. Whatever ends it, other than a
/// verdict, is a refusal.
class SandboxBuilder final : public Builder {
 public:
  struct Options {
    std::string program;      ///< this program, to be started as the child
    std::string scratch_dir;  ///< for unnamed files with voxels
    std::uint32_t time_limit_s = 300;
    std::uint64_t memory_limit_mb = 6144;
    std::uint64_t quota_mb = 2048;  ///< the largest volume
  };
  explicit SandboxBuilder(Options options) : options_(std::move(options)) {}
  Result<Build> build(const std::string& upload_path, const GoOn& go_on) override;
  Result<Build> cut(const CutInput& input, const GoOn& go_on) override;

 private:
  Result<Build> run(int input, const char* word, std::vector<std::string> more, const GoOn& go_on);
  Options options_;
};

/// The child's side of the options above: `arguments` as SandboxBuilder passes them.
int run_child_with(const std::vector<std::string>& arguments);
int run_cut_child_with(const std::vector<std::string>& arguments);

}  // namespace diaphane::ingest
