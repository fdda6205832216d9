#include "ingest/pipeline/label_child.h"

#include <optional>
#include <span>

#include "common/sandbox/supervisor.h"
#include "ingest/labels/read_labels.h"
#include "ingest/pipeline/child.h"
#include "ingest/pipeline/report.h"
#include "ingest/pipeline/tar_source.h"
#include "volume/header.h"

namespace diaphane::ingest {
namespace {

constexpr const char* kNeedsMore = "These labels need more memory than allowed.";

Verdict refusal_of(const Error& error, const volume::Header& scan) {
  if (error.field == kOtherScan) {
    if (scan.origin) return refused("labels_other_scan", error.message);
    return refused("labels_old_scan",
                   "This scan was added before labels could be, so it does not say where it lies "
                   "in the patient. Add the scan again, then add the labels.");
  }
  switch (error.code) {
    case ErrorCode::kTooLarge:
    case ErrorCode::kOutOfMemory:
      return refused("labels_too_large", error.message);
    case ErrorCode::kUnsupported:
      return refused("labels_unsupported", error.message);
    default:
      return refused("labels_damaged", error.message);
  }
}

/// Places the labels. Returns 0 and fills `verdict`, or returns an exit code.
int place(const std::string& header_text, Verdict& verdict) {
  auto scan = volume::from_json(header_text);
  if (!scan) {
    verdict = refused("internal", "The scan could not be read.");
    return 0;
  }
  const LabelLimits limits;
  TarSource source(kChildInput, limits.file_bytes);
  std::optional<Result<volume::LabelSet>> read;
  const auto first = [](std::size_t index) { return index == 0; };
  const auto visited =
      source.visit(first, [&](std::size_t, std::span<const std::byte> file) -> Result<void> {
        read = read_labels(file, *scan, limits);
        return {};
      });
  if (source.failed()) return kChildDiskFails;
  if (!visited || !read) {
    verdict = refused("labels_damaged", "The label file is damaged.");
    return 0;
  }
  if (!*read) {
    verdict = refusal_of(read->error(), *scan);
    return 0;
  }
  if (const int exit_code = write_output(volume::encode(**read))) return exit_code;
  return succeed(*std::move(scan), verdict);
}

}  // namespace

int run_label_child_main(const std::string& header, const SandboxLimits& sandbox) {
  return run_in_sandbox(sandbox, kNeedsMore,
                        [&](Verdict& verdict) { return place(header, verdict); });
}

}  // namespace diaphane::ingest
