#include "renderd/cli/stop_rule.h"

#include <algorithm>

namespace diaphane::render::cli {
namespace {

/// Largest piece, so that a watching user sees progress.
constexpr std::uint64_t kPiece = 32;
/// The error is unknown with fewer samples.
constexpr std::uint64_t kFirstLook = 2;

}  // namespace

const char* name_of(StopReason reason) {
  switch (reason) {
    case StopReason::kSamples:
      return "samples";
    case StopReason::kError:
      return "error";
    case StopReason::kSeconds:
      return "seconds";
  }
  return "";
}

Pace::Pace(const StopRule& rule) : rule_(rule), next_look_(kFirstLook) {}

std::uint32_t Pace::piece() const {
  // Renders one sample even without any time, because a picture needs one.
  if (rule_.seconds && done_ == 0) return 1;
  std::uint64_t piece = std::min<std::uint64_t>(kPiece, rule_.samples - done_);
  // The first pieces double the samples, so that the curve of the error begins early.
  piece = std::min(piece, std::max(kFirstLook, done_));
  if (rule_.error) piece = std::min(piece, next_look_ - done_);
  return static_cast<std::uint32_t>(std::max<std::uint64_t>(piece, 1));
}

void Pace::advance(std::uint64_t samples) {
  done_ = samples;
  due_ = rule_.error && (done_ >= next_look_ || done_ >= rule_.samples);
  if (done_ >= next_look_) next_look_ = done_ + std::max<std::uint64_t>(1, done_ / 4);
}

bool Pace::error_is_due() const { return due_; }

std::optional<StopReason> Pace::reached(double seconds, std::optional<double> error) const {
  if (rule_.error && error && *error <= *rule_.error) return StopReason::kError;
  if (done_ >= rule_.samples) return StopReason::kSamples;
  if (rule_.seconds && done_ > 0 && seconds >= *rule_.seconds) return StopReason::kSeconds;
  return {};
}

}  // namespace diaphane::render::cli
