#pragma once

#include <cstdint>
#include <string>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::ingest {

/// What became of an upload, in a form that can be shown and stored.
struct Verdict {
  bool ready = false;
  volume::Header header;  ///< with `ready`
  volume::Filler filler;  ///< the same
  std::string code;       ///< else: "too_few_slices", ...
  std::string text;       ///< a sentence
};

Verdict refused(std::string code, std::string text);
/// A volume of `bytes` for which the owner's quota leaves only `left`.
Verdict over_quota(std::uint64_t bytes, std::uint64_t left);

/// What a child writes for its parent.
std::string write_report(const Verdict& verdict);
/// What the parent makes of it. The child may have been taken over by what it read: the header must
/// pass volume's own checks, codes and sentences must look as ours do. kInvalid for anything else.
Result<Verdict> read_report(const std::string& report);

}  // namespace diaphane::ingest
