#include "renderd/schedule/visitor_share.h"

#include <algorithm>

namespace diaphane::render {
namespace {

/// Seconds per sample assumed for a session that was not measured: those of a slow GPU.
constexpr double kUnmeasuredSample = 0.001;
/// Seconds that visitors can save up: no more than a quantum, so that they never occupy the device
/// for long.
constexpr double kMostCredit = 0.008;
/// Seconds that visitors can owe, because a sample of a large picture on a slow device may take
/// longer than their share.
constexpr double kMostDebt = 2;

double cost_of(const Quantum& quantum, const SessionView& session) {
  const double sample =
      session.seconds_per_sample > 0 ? session.seconds_per_sample : kUnmeasuredSample;
  return quantum.samples * sample + (session.samples == 0 ? session.seconds_first : 0);
}

}  // namespace

std::vector<Quantum> VisitorShare::next(std::span<const SessionView> sessions) {
  return shared(sessions, [&](auto views) { return inner_->next(views); });
}

std::vector<Quantum> VisitorShare::overtaking(std::span<const SessionView> sessions,
                                              unsigned highest) {
  return shared(sessions, [&](auto views) { return inner_->overtaking(views, highest); });
}

std::vector<Quantum> VisitorShare::shared(std::span<const SessionView> sessions,
                                          const Choice& choice) {
  const bool contended = std::any_of(sessions.begin(), sessions.end(), [](const SessionView& one) {
    return !one.visitor && gains(one);
  });
  if (!contended) {
    credit_ = 0;
    return choice(sessions);
  }
  std::vector<Quantum> quanta;
  if (credit_ < 0) {
    std::vector<SessionView> holders;
    std::copy_if(sessions.begin(), sessions.end(), std::back_inserter(holders),
                 [](const SessionView& one) { return !one.visitor; });
    quanta = choice(holders);
  } else {
    quanta = choice(sessions);
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
