#pragma once

#include <functional>
#include <string>

#include "ingest/pipeline/builder.h"
#include "ingest/pipeline/clamd.h"

namespace diaphane::ingest {

/// Has every upload looked at for malware before anything reads it. What is infected is refused.
/// What could not be looked at waits until it can be, unless `pass_unchecked`.
class CheckedBuilder final : public Builder {
 public:
  struct Options {
    Clamd::Options clamd;
    bool pass_unchecked = false;
  };
  /// `tell` hears "clean", "infected" or "unchecked" of each upload.
  CheckedBuilder(Options options, Builder& inner, std::function<void(const std::string&)> tell)
      : clamd_(std::move(options.clamd)),
        pass_unchecked_(options.pass_unchecked),
        inner_(inner),
        tell_(std::move(tell)) {}

  Result<Build> build(const UploadInput& upload, const GoOn& go_on) override;
  /// Of what was looked at when it came.
  Result<Build> cut(const CutInput& input, const GoOn& go_on) override {
    return inner_.cut(input, go_on);
  }

 private:
  Clamd clamd_;
  bool pass_unchecked_;
  Builder& inner_;
  std::function<void(const std::string&)> tell_;
};

}  // namespace diaphane::ingest
