#include "ingest/pipeline/export_child.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <vector>

#include "common/sandbox/supervisor.h"
#include "common/try.h"
#include "ingest/export/export_scan.h"
#include "ingest/pipeline/child.h"
#include "ingest/pipeline/export_jobs.h"
#include "ingest/pipeline/report.h"
#include "volume/header.h"
#include "volume/labels.h"

namespace diaphane::ingest {
namespace {

constexpr const char* kExportNeedsMore = "This export needs more memory than allowed.";

/// Reads up to `bytes` bytes. Returns nullopt if the disk fails.
std::optional<std::size_t> read_input(char* data, std::size_t bytes) {
  std::size_t done = 0;
  while (done < bytes) {
    const ssize_t got = read(kChildInput, data + done, bytes - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return std::nullopt;
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

/// Turns a part that ingest has found into a label set.
Result<volume::LabelSet> found_set(const volume::FoundPart& part, const std::string& encoded,
                                   const volume::Header& header) {
  auto found = volume::decode(encoded, header.size);
  DIAPHANE_TRY(found);
  volume::LabelSet set{{{part.number(), "", volume::label_colour(0)}}, *std::move(found)};
  for (std::uint8_t& voxel : set.labels.voxels)
    voxel = voxel == static_cast<std::uint8_t>(part.label) ? 1 : 0;
  return set;
}

enum class Got { kAll, kDamaged, kDiskFails };

/// Reads one phase, or all of them.
Got read_voxels(volume::Volume& scan, std::optional<std::uint32_t> phase) {
  const std::uint64_t count = scan.header.voxel_count();
  scan.voxels.resize(phase ? count : scan.header.total_voxel_count());
  scan.phase = phase.value_or(0);
  const auto begin = static_cast<off_t>(count * scan.phase * sizeof(std::int16_t));
  if (lseek(kChildInput, begin, SEEK_SET) != begin) return Got::kDiskFails;
  const std::size_t bytes = scan.voxels.size() * sizeof(std::int16_t);
  const auto got = read_input(reinterpret_cast<char*>(scan.voxels.data()), bytes);
  if (!got) return Got::kDiskFails;
  return *got == bytes ? Got::kAll : Got::kDamaged;
}

Got read_labels(volume::Volume& scan, std::uint32_t number) {
  std::string encoded;
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  const std::uint64_t most = volume::most_label_set_bytes(scan.header);
  while (encoded.size() <= most) {
    const std::size_t before = encoded.size();
    encoded.resize(before + kPiece);
    const auto got = read_input(encoded.data() + before, kPiece);
    if (!got) return Got::kDiskFails;
    encoded.resize(before + *got);
    if (*got < kPiece) break;
  }
  const volume::FoundPart* part = volume::found_part(number);
  auto set = part != nullptr ? found_set(*part, encoded, scan.header)
                             : volume::decode_label_set(encoded, scan.header.size);
  if (!set) return Got::kDamaged;
  scan.label_set = *std::move(set);
  return Got::kAll;
}

Verdict refusal_of(const Error& error) {
  if (error.code == ErrorCode::kOutOfMemory) return refused("too_large", kExportNeedsMore);
  const char* code = error.code == ErrorCode::kTooLarge ? "too_large" : "nothing_inside";
  return refused(code, "This export is not possible: " + error.message + ".");
}

/// Exports the scan. Returns 0 and fills `verdict`, or returns an exit code.
int run_export(const std::string& header_text, const std::string& order_text, Verdict& verdict) {
  auto header = volume::from_json(header_text);
  const auto order = export_order_of(order_text);
  if (!header || !order) {
    verdict = refused("internal", "The scan could not be exported.");
    return 0;
  }
  volume::Volume scan;
  scan.header = *std::move(header);
  if (const auto known = volume::check_phase(scan.header, order->phase); !known) {
    verdict = refused("nothing_inside", "This export is not possible: the scan has no such phase.");
    return 0;
  }
  const auto phase = order->above ? std::optional(order->phase) : std::nullopt;
  const Got got = order->label ? read_labels(scan, *order->label) : read_voxels(scan, phase);
  if (got == Got::kDiskFails) return kChildDiskFails;
  if (got == Got::kDamaged) {
    verdict = refused("damaged", "The stored scan cannot be read.");
    return 0;
  }
  int exit_code = 0;
  const auto done = export_scan(scan, *order, {}, [&](std::string_view bytes) -> Result<void> {
    exit_code = write_output(bytes);
    if (exit_code != 0) return fail(ErrorCode::kUnavailable, "the disk fails");
    return {};
  });
  if (exit_code != 0) return exit_code;
  if (!done) {
    verdict = refusal_of(done.error());
    return 0;
  }
  return succeed(std::move(scan.header), verdict);
}

}  // namespace

int run_export_child_main(const std::string& header, const std::string& order,
                          const SandboxLimits& sandbox) {
  return run_in_sandbox(sandbox, kExportNeedsMore,
                        [&](Verdict& verdict) { return run_export(header, order, verdict); });
}

}  // namespace diaphane::ingest
