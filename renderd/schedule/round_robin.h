#pragma once

#include "renderd/schedule/policy.h"

namespace diaphane::render {

/// True while another sample changes what somebody sees: visible and not yet at the target error.
bool gains(const SessionView& session);

/// Every session that gains takes its turn, in order of handles; a baseline of the thesis (7).
/// A quantum is as many samples as fit `quantum_seconds`, at least one, and at most as many as the
/// session has, so that frames at the doublings of the sample count are not jumped over. The first
/// of an epoch fits `first_seconds`: a fast device shows a better picture before anybody notices.
class RoundRobin final : public Policy {
 public:
  struct Options {
    double quantum_seconds = 0.03;  ///< input to anybody's picture waits at most about this long
    double first_seconds = 0.008;
    std::uint32_t max_samples = 1024;
  };

  RoundRobin() = default;
  explicit RoundRobin(Options options) : options_(options) {}
  std::optional<Quantum> next(std::span<const SessionView> sessions) override;

 private:
  Options options_;
  std::uint64_t last_ = 0;  // handle of the session that had the last turn
};

}  // namespace diaphane::render
