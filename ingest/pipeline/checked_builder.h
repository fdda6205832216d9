#pragma once

#include <functional>
#include <optional>
#include <string>

#include "ingest/pipeline/builder.h"
#include "ingest/pipeline/clamd.h"

namespace diaphane::ingest {

/// Scans every upload for malware before anything reads it. Infected uploads are refused. An upload
/// that cannot be scanned waits until it can be, unless `pass_unchecked` is set.
class CheckedBuilder final : public Builder {
 public:
  struct Options {
    Clamd::Options clamd;
    bool pass_unchecked = false;
  };
  /// `report` receives "clean", "infected" or "unchecked" for each upload.
  CheckedBuilder(Options options, Builder& inner, std::function<void(const std::string&)> report)
      : clamd_(std::move(options.clamd)),
        pass_unchecked_(options.pass_unchecked),
        inner_(inner),
        report_(std::move(report)) {}

  Result<Build> build(const UploadInput& upload, const ShouldContinue& should_continue) override;
  Result<Build> place_labels(const LabelInput& input,
                             const ShouldContinue& should_continue) override;
  /// Cuts without another scan for malware, because the upload of the volume was scanned.
  Result<Build> cut(const CutInput& input, const ShouldContinue& should_continue) override {
    return inner_.cut(input, should_continue);
  }

 private:
  /// Scans the file at `path`. Returns nullopt if it may be read.
  std::optional<Result<Build>> check(const std::string& path,
                                     const ShouldContinue& should_continue);

  Clamd clamd_;
  bool pass_unchecked_;
  Builder& inner_;
  std::function<void(const std::string&)> report_;
};

}  // namespace diaphane::ingest
