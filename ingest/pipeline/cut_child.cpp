#include "ingest/pipeline/cut_child.h"

#include <unistd.h>

#include <cerrno>
#include <new>

#include "ingest/pipeline/child.h"
#include "ingest/pipeline/report.h"
#include "ingest/pipeline/supervisor.h"
#include "volume/header.h"
#include "volume/region.h"

namespace diaphane::ingest {
namespace {

/// The next slice; the sandbox lets it read on and seek, no more.
bool read_slice(std::vector<std::int16_t>& slice) {
  char* at = reinterpret_cast<char*>(slice.data());
  std::size_t bytes = slice.size() * sizeof(std::int16_t);
  while (bytes > 0) {
    const ssize_t got = read(kChildInput, at, bytes);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

/// Leaves a verdict, or an exit code.
int cut(const std::string& header_text, const std::string& region_text, Verdict& verdict) {
  const auto refuse = [&](const char* code, const char* text) {
    verdict = refused(code, text);
    return 0;
  };
  const auto header = volume::from_json(header_text);
  const auto region = volume::region_from_json(region_text);
  if (!header || !region) return refuse("internal", "The cut could not be made.");
  const auto plan = volume::plan_cut(*header, *region);
  if (!plan) return refuse("nothing_left", "Too little of the scan would be left.");
  std::vector<std::int16_t> from(std::size_t{header->size[0]} * header->size[1]);
  std::vector<std::int16_t> to(std::size_t{plan->size[0]} * plan->size[1]);
  const auto begin = static_cast<off_t>(plan->low[2] * from.size() * sizeof(std::int16_t));
  if (lseek(kChildInput, begin, SEEK_SET) != begin) {
    return kChildDiskFails;
  }
  for (std::uint32_t z = 0; z < plan->size[2]; ++z) {
    if (!read_slice(from)) return refuse("damaged", "The stored scan cannot be read.");
    volume::cut_slice(*header, *region, *plan, z, from, to);
    int exit_code = 0;
    if (!write_output(to.data(), to.size(), exit_code)) return exit_code;
  }
  verdict.ready = true;
  verdict.header = volume::after(*header, *plan);
  return 0;
}

}  // namespace

int run_cut_child_main(const std::string& header, const std::string& region,
                       const SandboxLimits& sandbox) {
  if (!enter_sandbox(sandbox)) return kChildNoSandbox;
  Verdict verdict;
  int exit_code = 0;
  try {
    exit_code = cut(header, region, verdict);
  } catch (const std::bad_alloc&) {
    verdict = refused("too_large", "The cut needs more memory than is allowed.");
  }
  return exit_code != 0 ? exit_code : send_report(verdict);
}

}  // namespace diaphane::ingest
