#include "ingest/pipeline/child.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "common/sandbox/supervisor.h"
#include "ingest/body/label_body.h"
#include "ingest/build/build_volume.h"
#include "ingest/build/nifti.h"
#include "ingest/pipeline/memory_shortage.h"
#include "ingest/pipeline/report.h"
#include "ingest/pipeline/tar_source.h"

namespace diaphane::ingest {

namespace {

/// Writes all bytes. Returns 0 or the errno of the failure.
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

int write_output(std::string_view bytes) {
  const int error = write_all(kChildOutput, bytes.data(), bytes.size());
  if (error == 0) return 0;
  return error == ENOSPC || error == EDQUOT ? kChildNoRoom : kChildDiskFails;
}

int write_output(const volume::Volume& volume) {
  const std::string labels = found_labels(volume);
  const int exit_code =
      write_output(std::string_view(reinterpret_cast<const char*>(volume.voxels.data()),
                                    volume.voxels.size() * sizeof(std::int16_t)));
  return exit_code != 0 ? exit_code : write_output(labels);
}

int succeed(volume::Header scan, Verdict& verdict) {
  verdict.ready = true;
  verdict.header = std::move(scan);
  // The parent refuses headers with these fields, because it fills them itself.
  verdict.header.content_hash.clear();
  verdict.header.label_hash.clear();
  verdict.header.frame_of_reference.clear();
  return 0;
}

int send_report(const Verdict& verdict) {
  const std::string report = write_report(verdict);
  if (report.size() > kLongestReport) return kChildBadReport;
  return write_all(kChildReport, report.data(), report.size()) == 0 ? 0 : kChildDiskFails;
}

int run_in_sandbox(const SandboxLimits& sandbox, const char* refusal_for_memory,
                   const std::function<int(Verdict&)>& work) {
  try {
    end_when_machine_is_short_of_memory(kChildNoMemory);
    if (!enter_sandbox(sandbox)) return kChildNoSandbox;
    if (write_all(kChildReport, &kChildBegins, 1) != 0) return kChildDiskFails;
    Verdict verdict;
    int exit_code = 0;
    try {
      exit_code = work(verdict);
    } catch (const std::bad_alloc&) {
      verdict = refused("too_large", refusal_for_memory);
    }
    return exit_code != 0 ? exit_code : send_report(verdict);
  } catch (const std::bad_alloc&) {
    return kChildNoMemory;  // not even a few hundred bytes are left
  }
}

namespace {

constexpr const char* kNeedsMore = "This upload needs more memory than allowed.";

Verdict refusal_of(const Error& error) {
  if (error.code == ErrorCode::kOutOfMemory) return refused("too_large", kNeedsMore);
  if (error.code == ErrorCode::kTooLarge) {
    return refused("too_large", "This upload was refused: " + error.message + ".");
  }
  if (error.code == ErrorCode::kUnsupported) {
    return refused("values_out_of_range", "This scan cannot be displayed: " + error.message + ".");
  }
  return refused("damaged", "This upload cannot be read: " + error.message + ".");
}

std::uint64_t volume_bytes(const dicom::Assessment& found) {
  return std::uint64_t{found.size[0]} * found.size[1] * found.size[2] *
         std::max<std::size_t>(found.phases.size(), 1) * sizeof(std::int16_t);
}

/// Returns an exit code if a volume of `bytes` must not be built now. Otherwise returns 0, with a
/// verdict if it exceeds the quota.
int check_bounds(std::uint64_t bytes, const BuildBounds& bounds, Verdict& verdict) {
  if (bytes > bounds.quota_left) {
    verdict = over_quota(bytes, bounds.quota_left);
    return 0;
  }
  if (bytes > bounds.light_bytes) return kChildTooLarge;
  return bytes > bounds.room_bytes ? kChildNoRoom : 0;
}

int deliver(volume::Volume& volume, const volume::Filler& filler, Verdict& verdict) {
  if (const int exit_code = write_output(volume)) return exit_code;
  verdict.ready = true;
  verdict.header = std::move(volume.header);
  verdict.filler = filler;
  return 0;
}

/// Minimum number of slices. Fewer have too little depth to show.
constexpr std::uint32_t kFewestSlices = 16;

/// Builds a scan in a research format. Returns 0 and fills `verdict`, or returns an exit code.
int build_nifti(std::span<const std::byte> file, const dicom::ScanLimits& limits,
                const BuildBounds& bounds, Verdict& verdict) {
  const auto header = read_nifti_header(file);
  const auto refuse = [&](Verdict refusal) {
    verdict = std::move(refusal);
    return 0;
  };
  if (!header) return refuse(refusal_of(header.error()));
  const auto& size = header->size;
  const std::uint64_t voxels =
      std::uint64_t{size[0]} * size[1] * size[2] * std::max<std::size_t>(header->phases.size(), 1);
  if (const std::uint32_t fewest = std::min({size[0], size[1], size[2]}); fewest < kFewestSlices) {
    return refuse(refused("too_few_slices", "This scan has only " + std::to_string(fewest) +
                                                " slices, and at least 16 are needed."));
  }
  if (voxels > limits.most_voxels) {
    return refuse(refused("too_large", "This upload was refused: the image is too large."));
  }
  if (const int code = check_bounds(voxels * sizeof(std::int16_t), bounds, verdict)) return code;
  if (!verdict.code.empty()) return 0;
  auto volume = read_nifti_voxels(file, *header);
  if (!volume) return refuse(refusal_of(volume.error()));
  return deliver(*volume, {}, verdict);
}

/// Builds the uploaded scan. Returns 0 and fills `verdict`, or returns an exit code.
int build(const dicom::ScanLimits& limits, const BuildBounds& bounds, Verdict& verdict) {
  const auto refuse = [&](Verdict refusal) {
    verdict = std::move(refusal);
    return 0;
  };
  TarSource source(kChildInput, limits.file.file_bytes);
  std::optional<int> done;
  const auto first = [](std::size_t index) { return index == 0; };
  // The scan below finds any error of this visit again.
  (void)source.visit(first, [&](std::size_t, std::span<const std::byte> file) -> Result<void> {
    if (is_nifti(file)) done = build_nifti(file, limits, bounds, verdict);
    return {};
  });
  if (source.failed()) return kChildDiskFails;
  if (done) return *done;
  auto scan = dicom::scan(source, limits);
  if (source.failed()) return kChildDiskFails;
  if (!scan) return refuse(refusal_of(scan.error()));
  const dicom::Choice choice = dicom::choose(*scan);
  if (!choice.suitable) return refuse(refused(choice.code, choice.text));
  const std::uint64_t bytes = volume_bytes(scan->series[choice.index].assessment);
  if (const int code = check_bounds(bytes, bounds, verdict)) return code;
  if (!verdict.code.empty()) return 0;
  auto built = build_volume(source, *scan, choice, limits.file);
  if (source.failed()) return kChildDiskFails;
  if (!built) return refuse(refusal_of(built.error()));
  return deliver(built->volume, built->filler, verdict);
}

}  // namespace

int run_child_main(const dicom::ScanLimits& limits, const BuildBounds& bounds,
                   const SandboxLimits& sandbox) {
  return run_in_sandbox(sandbox, kNeedsMore,
                        [&](Verdict& verdict) { return build(limits, bounds, verdict); });
}

}  // namespace diaphane::ingest
