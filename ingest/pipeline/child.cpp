#include "ingest/pipeline/child.h"

#include <unistd.h>

#include <new>

#include "ingest/build/build_volume.h"
#include "ingest/pipeline/report.h"
#include "ingest/pipeline/supervisor.h"
#include "ingest/pipeline/tar_source.h"

namespace diaphane::ingest {

bool write_all(int fd, const char* data, std::size_t bytes) {
  while (bytes > 0) {
    const ssize_t done = write(fd, data, bytes);
    if (done <= 0) return false;
    data += done;
    bytes -= static_cast<std::size_t>(done);
  }
  return true;
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
  return refused("damaged", "This upload cannot be read: " + error.message + ".");
}

Verdict build(const dicom::ScanLimits& limits) {
  TarSource source(kChildInput, limits.file.file_bytes);
  auto scan = dicom::scan(source, limits);
  if (!scan) return refusal_of(scan.error());
  const dicom::Choice choice = dicom::choose(*scan);
  if (!choice.suitable) return refused(choice.code, choice.text);
  auto built = build_volume(source, *scan, choice, limits.file);
  if (!built) return refusal_of(built.error());
  volume::Volume& volume = built->volume;
  if (!write_all(kChildOutput, reinterpret_cast<const char*>(volume.voxels.data()),
                 volume.voxels.size() * sizeof(std::int16_t))) {
    return refused("internal", "The volume could not be kept; please try again later.");
  }
  Verdict verdict;
  verdict.ready = true;
  verdict.header = std::move(volume.header);
  verdict.filler = built->filler;
  return verdict;
}

}  // namespace

int run_child_main(const dicom::ScanLimits& limits, const SandboxLimits& sandbox) {
  constexpr int kNoSandbox = 70;
  if (!enter_sandbox(sandbox)) return kNoSandbox;
  Verdict verdict;
  try {
    verdict = build(limits);
  } catch (const std::bad_alloc&) {
    verdict = out_of_memory();
  }
  const std::string report = write_report(verdict);
  return report.size() <= kLongestReport && write_all(kChildReport, report.data(), report.size())
             ? 0
             : kNoSandbox;
}

}  // namespace diaphane::ingest
