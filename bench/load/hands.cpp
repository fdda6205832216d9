#include "bench/load/hands.h"

#include <algorithm>
#include <numeric>

namespace diaphane::api::load {

Hands::Hands(const render::bench::Trace& trace, std::size_t moving)
    : done_(trace.sessions.size()),
      moving_(std::clamp<std::size_t>(moving, 1, std::max<std::size_t>(trace.sessions.size(), 1))) {
  std::vector<double> begins;
  for (const render::bench::TraceSession& session : trace.sessions) {
    std::vector<double> lengths;
    for (const render::bench::Span& gesture : session.gestures) {
      lengths.push_back(gesture.end - gesture.begin);
    }
    begins.push_back(session.gestures.empty() ? trace.seconds : session.gestures.front().begin);
    if (lengths.empty()) lengths.push_back(1.0);  // a user who only looked gets one short drag
    lengths_.push_back(std::move(lengths));
  }
  resting_.resize(lengths_.size());
  std::iota(resting_.begin(), resting_.end(), std::size_t{0});
  std::stable_sort(resting_.begin(), resting_.end(),
                   [&](std::size_t a, std::size_t b) { return begins[a] < begins[b]; });
}

Hands::Gesture Hands::next() {
  const std::size_t session = resting_.front();
  resting_.pop_front();
  const std::vector<double>& lengths = lengths_[session];
  return {session, lengths[done_[session]++ % lengths.size()]};
}

std::vector<Hands::Gesture> Hands::begin() {
  std::vector<Gesture> first;
  while (first.size() < moving_) first.push_back(next());
  return first;
}

Hands::Gesture Hands::after(std::size_t session) {
  // Queued before the next session is taken, so that a single session continues with itself.
  resting_.push_back(session);
  return next();
}

}  // namespace diaphane::api::load
