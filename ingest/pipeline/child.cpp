#include "ingest/pipeline/child.h"

#include <unistd.h>

#include <cerrno>
#include <new>
#include <utility>

#include "ingest/build/build_volume.h"
#include "ingest/pipeline/report.h"
#include "ingest/pipeline/supervisor.h"
#include "ingest/pipeline/tar_source.h"

namespace diaphane::ingest {

namespace {

/// Zero, or the error that ended it.
int write_all(int fd, const char* data, std::size_t bytes) {
  while (bytes > 0) {
    const ssize_t done = write(fd, data, bytes);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) return done < 0 ? errno : ENOSPC;
    data += done;
    bytes -= static_cast<std::size_t>(done);
  }
  return 0;
}

}  // namespace

bool write_output(const std::int16_t* voxels, std::size_t count, int& exit_code) {
  const int error =
      write_all(kChildOutput, reinterpret_cast<const char*>(voxels), count * sizeof(std::int16_t));
  if (error == 0) return true;
  exit_code = error == ENOSPC || error == EDQUOT ? kChildNoRoom : kChildDiskFails;
  return false;
}

int send_report(const Verdict& verdict) {
  const std::string report = write_report(verdict);
  if (report.size() > kLongestReport) return kChildBadReport;
  return write_all(kChildReport, report.data(), report.size()) == 0 ? 0 : kChildDiskFails;
}

namespace {

Verdict out_of_memory() {
  return refused("too_large", "This upload needs more memory than is allowed.");
}

Verdict refusal_of(const Error& error) {
  if (error.code == ErrorCode::kOutOfMemory) return out_of_memory();
  if (error.code == ErrorCode::kTooLarge) {
    return refused("too_large", "This upload is refused: " + error.message + ".");
  }
  if (error.code == ErrorCode::kUnsupported) {
    return refused("values_out_of_range", "This scan cannot be shown: " + error.message + ".");
  }
  return refused("damaged", "This upload cannot be read: " + error.message + ".");
}

std::uint64_t volume_bytes(const dicom::Assessment& found) {
  return std::uint64_t{found.size[0]} * found.size[1] * found.size[2] * sizeof(std::int16_t);
}

/// Leaves a verdict, or an exit code.
int build(const dicom::ScanLimits& limits, const BuildBounds& bounds, Verdict& verdict) {
  const auto refuse = [&](Verdict refusal) {
    verdict = std::move(refusal);
    return 0;
  };
  TarSource source(kChildInput, limits.file.file_bytes);
  auto scan = dicom::scan(source, limits);
  if (!scan) return refuse(refusal_of(scan.error()));
  const dicom::Choice choice = dicom::choose(*scan);
  if (!choice.suitable) return refuse(refused(choice.code, choice.text));
  const std::uint64_t bytes = volume_bytes(scan->series[choice.index].assessment);
  if (bytes > bounds.quota_left) return refuse(over_quota(bytes, bounds.quota_left));
  if (bytes > bounds.light_bytes) return kChildTooLarge;
  if (bytes > bounds.room_bytes) return kChildNoRoom;
  auto built = build_volume(source, *scan, choice, limits.file);
  if (!built) return refuse(refusal_of(built.error()));
  volume::Volume& volume = built->volume;
  int exit_code = 0;
  if (!write_output(volume.voxels.data(), volume.voxels.size(), exit_code)) return exit_code;
  verdict.ready = true;
  verdict.header = std::move(volume.header);
  verdict.filler = built->filler;
  return 0;
}

}  // namespace

int run_child_main(const dicom::ScanLimits& limits, const BuildBounds& bounds,
                   const SandboxLimits& sandbox) {
  if (!enter_sandbox(sandbox)) return kChildNoSandbox;
  Verdict verdict;
  int exit_code = 0;
  try {
    exit_code = build(limits, bounds, verdict);
  } catch (const std::bad_alloc&) {
    verdict = out_of_memory();
  }
  return exit_code != 0 ? exit_code : send_report(verdict);
}

}  // namespace diaphane::ingest
