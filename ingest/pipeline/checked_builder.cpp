#include "ingest/pipeline/checked_builder.h"

#include <fcntl.h>
#include <unistd.h>

#include "common/log.h"

namespace diaphane::ingest {
namespace {

Build refusal(const char* code, const char* text) {
  Build build;
  build.verdict = refused(code, text);
  return build;
}

}  // namespace

Result<Build> CheckedBuilder::build(const UploadInput& upload,
                                    const ShouldContinue& should_continue) {
  if (auto end = check(upload.path, should_continue)) return *std::move(end);
  return inner_.build(upload, should_continue);
}

Result<Build> CheckedBuilder::place_labels(const LabelInput& input,
                                           const ShouldContinue& should_continue) {
  if (auto end = check(input.path, should_continue)) return *std::move(end);
  return inner_.place_labels(input, should_continue);
}

std::optional<Result<Build>> CheckedBuilder::check(const std::string& path,
                                                   const ShouldContinue& should_continue) {
  const int input = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (input < 0) return std::nullopt;  // the inner builder reports the reason
  const auto found = clamd_.look_at(input, should_continue);
  close(input);
  if (!found) {
    report_("unchecked");
    log::error("virus_scanner_unavailable", {{"reason", found.error().message},
                                             {"effect", pass_unchecked_ ? "passed" : "waits"}});
    if (pass_unchecked_) return std::nullopt;
    return Result<Build>(fail(ErrorCode::kUnavailable, "the virus scanner is unavailable"));
  }
  if (*found == Clamd::Found::kStopped) {
    Build stopped;
    stopped.stopped = true;
    return Result<Build>(std::move(stopped));
  }
  if (*found == Clamd::Found::kInfected) {
    report_("infected");
    return Result<Build>(
        refusal("infected",
                "The virus scanner found malicious software in this upload, so the upload was "
                "deleted."));
  }
  report_("clean");
  return std::nullopt;
}

}  // namespace diaphane::ingest
