#include "renderd/schedule/visitor_share.h"

#include <algorithm>

namespace diaphane::render {
namespace {

/// Before a session's cost is known, that of a picture of a slow GPU.
constexpr double kUnknownCost = 0.001;
/// What visitors can save up: no more than a quantum, so that they never hold the device for long.
constexpr double kMostCredit = 0.008;
/// What they can owe: a sample of a large picture on a slow device may take longer than their
/// share.
constexpr double kMostDebt = 2;

double cost_of(const Quantum& quantum, const SessionView& session) {
  const double sample = session.seconds_per_sample > 0 ? session.seconds_per_sample : kUnknownCost;
  return quantum.samples * sample + (session.samples == 0 ? session.seconds_first : 0);
}

}  // namespace

std::vector<Quantum> VisitorShare::next(std::span<const SessionView> sessions) {
  const bool contended = std::any_of(sessions.begin(), sessions.end(), [](const SessionView& one) {
    return !one.visitor && gains(one);
  });
  if (!contended) {
    credit_ = 0;
    return inner_->next(sessions);
  }
  std::vector<Quantum> quanta;
  if (credit_ < 0) {
    std::vector<SessionView> holders;
    std::copy_if(sessions.begin(), sessions.end(), std::back_inserter(holders),
                 [](const SessionView& one) { return !one.visitor; });
    quanta = inner_->next(holders);
  } else {
    quanta = inner_->next(sessions);
  }
  for (const Quantum& quantum : quanta) {
    const auto session = std::find_if(sessions.begin(), sessions.end(), [&](const auto& one) {
      return one.session == quantum.session;
    });
    const double cost = cost_of(quantum, *session);
    credit_ += session->visitor ? -cost * (1 - share_) : cost * share_;
  }
  credit_ = std::clamp(credit_, -kMostDebt, kMostCredit);
  return quanta;
}

}  // namespace diaphane::render
