#pragma once

#include <cstdint>
#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// The outcome of a job, in a form that can be shown and stored.
struct Verdict {
  bool ready = false;
  volume::Header header;  ///< valid with `ready`
  volume::Filler filler;  ///< valid with `ready`
  std::string code;       ///< reason for a refusal: "too_few_slices", ...
  std::string text;       ///< the reason as a sentence
};

Verdict refused(std::string code, std::string text);
/// Returns the refusal of a volume of `bytes` for which the owner's quota leaves only `left`.
Verdict over_quota(std::uint64_t bytes, std::uint64_t left);

/// Serialises a child's verdict for its parent.
std::string write_report(const Verdict& verdict);
/// Parses the report in the parent. The child may be compromised by its input, so the header must
/// pass the checks of volume/, and codes and sentences must have the expected form. Returns
/// kInvalid for anything else.
Result<Verdict> read_report(const std::string& report);

}  // namespace diaphane::ingest
