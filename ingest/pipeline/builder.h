#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/fd.h"
#include "common/result.h"
#include "common/sandbox/sandbox.h"
#include "ingest/dicom/scan.h"
#include "ingest/export/export_scan.h"
#include "ingest/pipeline/report.h"
#include "ingest/registration/register.h"
#include "volume/region.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// The result of reading one upload. At most one of the flags is set, and then there is no verdict.
struct Build {
  Verdict verdict;
  volume::Volume volume;  ///< valid with verdict.ready, with measured statistics
  std::string frame;      ///< UID of the frame of reference in disguise, or empty
  std::string labels;     ///< instead of a volume: the encoded label set (place_labels)
  bool stopped = false;   ///< `should_continue` returned false
  bool killed = false;    ///< something killed the child, probably the kernel for lack of memory
  bool delayed = false;   ///< the machine was too busy to finish in time
  /// The child could not allocate memory although it was below its own limit.
  bool no_memory = false;
  bool too_large = false;  ///< exceeds BuildBounds::light_bytes
  /// The upload's file is missing from a directory in which others were found.
  bool file_missing = false;
  std::optional<RigidAlignment> aligned;  ///< instead of a volume (SandboxBuilder::align)
  std::uint64_t written = 0;  ///< bytes of the exported file (SandboxBuilder::export_scan)
  double seconds = 0;
  std::uint64_t peak_bytes = 0;  ///< peak memory of the child
};

/// An upload and the limits of its volume. A volume that exceeds them is never written.
struct UploadInput {
  std::string path;
  std::optional<std::uint64_t> quota_left;  ///< bytes; a larger volume is refused ("over_quota")
};

/// A stored volume to cut (docs/contracts.md, "Anonymising").
struct CutInput {
  std::string volume_directory;
  volume::Header header;  ///< as stored
  volume::Region region;
};

/// An upload of labels and the stored scan that they are for.
struct LabelInput {
  std::string path;
  volume::Header scan;
};

/// A stored volume to export, and the new file for it.
struct ExportInput {
  std::string volume_directory;
  volume::Header header;  ///< as stored
  ExportOrder order;
  std::string path;
};

/// Two stored volumes to align.
struct AlignInput {
  std::string fixed_directory, moving_directory;
  volume::Header fixed, moving;  ///< as stored
};

/// Builds a volume from an upload, cuts a stored volume, or places labels on its grid. Whatever the
/// contents of its input, they cannot affect this process.
class Builder {
 public:
  using ShouldContinue = std::function<bool()>;
  virtual ~Builder() = default;
  /// Returns a refusal for any problem with the contents of the file. An error is a temporary
  /// condition: kTooLarge for a full disk, kOutOfMemory, and kUnavailable or kInternal for the
  /// rest.
  virtual Result<Build> build(const UploadInput& upload, const ShouldContinue& should_continue) = 0;
  /// Returns the kept part of a stored volume, which is not changed. Refuses if nothing would be
  /// left. The errors are those of build().
  virtual Result<Build> cut(const CutInput& input, const ShouldContinue& should_continue) = 0;
  /// Returns the labels of an upload on the grid of a scan. The errors are those of build().
  virtual Result<Build> place_labels(const LabelInput& input,
                                     const ShouldContinue& should_continue) = 0;
};

/// Builds in a sandboxed child process (child.h), one per job. A child that crashes over its input
/// or takes too long is a refusal. Its exit codes for temporary conditions are errors, and a child
/// that was killed or got no memory gives no verdict. Not thread-safe.
class SandboxBuilder final : public Builder {
 public:
  struct Options {
    std::string program;             ///< path of this program, which also runs as the child
    std::string scratch_dir;         ///< for unnamed files with voxels or labels
    std::string volume_dir;          ///< where the volume will be stored
    std::uint64_t reserve_mb = 256;  ///< space to keep free on both disks
    std::uint64_t light_mb = 0;      ///< larger volumes are left to another worker; 0: no limit
    std::uint32_t time_limit_s = 300;
    std::uint64_t memory_limit_mb = 6144;
    std::uint64_t quota_mb = 2048;  ///< the largest volume
  };
  explicit SandboxBuilder(Options options) : options_(std::move(options)) {}
  Result<Build> build(const UploadInput& upload, const ShouldContinue& should_continue) override;
  Result<Build> cut(const CutInput& input, const ShouldContinue& should_continue) override;
  Result<Build> place_labels(const LabelInput& input,
                             const ShouldContinue& should_continue) override;
  /// Writes an export of a stored volume to `input.path`. Refuses an order that is not possible.
  /// The errors are those of build(), and then a part of the file may remain.
  Result<Build> export_scan(const ExportInput& input, const ShouldContinue& should_continue);
  /// Aligns two stored volumes. Refuses what register_rigid() refuses, with its reason as the code.
  /// The errors are those of build().
  Result<Build> align(const AlignInput& input, const ShouldContinue& should_continue);

 private:
  /// Reads what the child wrote to the file, if its verdict is "ready".
  using TakeOutput = std::function<Result<void>(int output, Build& build)>;
  Result<Build> run(int input, const char* word, std::vector<std::string> more,
                    const TakeOutput& take_output, const ShouldContinue& should_continue);
  /// Opens an upload. Sets `build.file_missing` and returns no file if it is missing.
  Result<Fd> open_upload(const std::string& path, Build& build);
  std::uint64_t room_bytes() const;
  /// Identifies a directory and the file system that is mounted there. nullopt if it cannot be
  /// determined.
  using DirectoryId = std::pair<std::uint64_t, std::uint64_t>;
  static std::optional<DirectoryId> directory_of(const std::string& path);
  Options options_;
  std::optional<DirectoryId> uploads_;  ///< where the last upload was found
};

/// Main functions of the children. `arguments` come from SandboxBuilder. Return the exit code.
int run_child_with(const std::vector<std::string>& arguments);
int run_cut_child_with(const std::vector<std::string>& arguments);
int run_label_child_with(const std::vector<std::string>& arguments);
int run_export_child_with(const std::vector<std::string>& arguments);
int run_align_child_with(const std::vector<std::string>& arguments);

}  // namespace diaphane::ingest
