#include "ingest/pipeline/cut_child.h"

#include <unistd.h>

#include <cerrno>
#include <span>

#include "common/sandbox/supervisor.h"
#include "ingest/pipeline/child.h"
#include "ingest/pipeline/report.h"
#include "volume/header.h"
#include "volume/region.h"

namespace diaphane::ingest {
namespace {

enum class Got { kAll, kTooLittle, kDiskFails };

/// Reads the next slice. The sandbox allows only reading forward and seeking.
Got read_slice(std::vector<std::int16_t>& slice) {
  char* at = reinterpret_cast<char*>(slice.data());
  std::size_t bytes = slice.size() * sizeof(std::int16_t);
  while (bytes > 0) {
    const ssize_t got = read(kChildInput, at, bytes);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return got < 0 ? Got::kDiskFails : Got::kTooLittle;
    at += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return Got::kAll;
}

/// Cuts the volume. Returns 0 and fills `verdict`, or returns an exit code.
int cut(const std::string& header_text, const std::string& region_text, Verdict& verdict) {
  const auto refuse = [&](const char* code, const char* text) {
    verdict = refused(code, text);
    return 0;
  };
  const auto header = volume::from_json(header_text);
  const auto region = volume::region_from_json(region_text);
  if (!header || !region) return refuse("internal", "The scan could not be cropped.");
  const auto plan = volume::plan_cut(*header, *region);
  if (!plan) return refuse("nothing_left", "Too little of the scan would remain.");
  std::vector<std::int16_t> from(std::size_t{header->size[0]} * header->size[1]);
  volume::Volume left;
  left.header = volume::after(*header, *plan);
  left.voxels.resize(left.header.total_voxel_count());
  const std::size_t slice = std::size_t{plan->size[0]} * plan->size[1];
  const std::size_t slices = plan->size[2] * left.header.phase_count();
  for (std::size_t k = 0; k < slices; ++k) {
    const auto z = static_cast<std::uint32_t>(k % plan->size[2]);
    if (z == 0) {
      const std::size_t phase = k / plan->size[2];
      const auto begin = static_cast<off_t>((phase * header->size[2] + plan->low[2]) * from.size() *
                                            sizeof(std::int16_t));
      if (lseek(kChildInput, begin, SEEK_SET) != begin) return kChildDiskFails;
    }
    const Got got = read_slice(from);
    if (got == Got::kDiskFails) return kChildDiskFails;
    if (got == Got::kTooLittle) return refuse("damaged", "The stored scan cannot be read.");
    volume::cut_slice(*header, *region, *plan, z, from,
                      std::span(left.voxels).subspan(k * slice, slice));
  }
  // write_output() computes new labels, because the old ones show the shape of what was removed.
  volume::measure(left);
  if (const int exit_code = write_output(left)) return exit_code;
  verdict.ready = true;
  verdict.header = std::move(left.header);
  return 0;
}

}  // namespace

int run_cut_child_main(const std::string& header, const std::string& region,
                       const SandboxLimits& sandbox) {
  return run_in_sandbox(sandbox, "Cropping this scan needs more memory than allowed.",
                        [&](Verdict& verdict) { return cut(header, region, verdict); });
}

}  // namespace diaphane::ingest
