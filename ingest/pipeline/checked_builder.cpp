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
  const int input = open(upload.path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (input < 0)
    return inner_.build(upload, should_continue);  // the inner builder reports the reason
  const auto found = clamd_.look_at(input, should_continue);
  close(input);
  if (!found) {
    report_("unchecked");
    log::error("virus_scanner_unavailable", {{"reason", found.error().message},
                                             {"effect", pass_unchecked_ ? "passed" : "waits"}});
    if (pass_unchecked_) return inner_.build(upload, should_continue);
    return fail(ErrorCode::kUnavailable, "the virus scanner is unavailable");
  }
  if (*found == Clamd::Found::kStopped) {
    Build stopped;
    stopped.stopped = true;
    return stopped;
  }
  if (*found == Clamd::Found::kInfected) {
    report_("infected");
    return refusal("infected",
                   "The virus scanner found malicious software in this upload, so the upload was "
                   "deleted.");
  }
  report_("clean");
  return inner_.build(upload, should_continue);
}

}  // namespace diaphane::ingest
