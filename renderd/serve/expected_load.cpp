#include "renderd/serve/expected_load.h"

#include <algorithm>
#include <vector>

namespace diaphane::render {

double ExpectedLoad::after(double seconds, double busy, std::span<const Usage> sessions,
                           std::size_t slots) {
  if (!(seconds > 0)) seconds = 0;
  busy = std::clamp(busy, 0.0, seconds);
  std::map<std::string, Watched> now;
  std::vector<double> took;
  double all = 0;
  for (const Usage& one : sessions) {
    const auto before = sessions_.find(one.id);
    Watched& watched = now[one.id];
    if (before != sessions_.end()) watched = before->second;
    took.push_back(std::max(0.0, one.device_seconds - watched.device_seconds));
    watched.device_seconds = one.device_seconds;
    all += took.back();
  }
  // Work that ran at the same time used the device only once.
  const double scale = all > busy ? busy / all : 1;
  const double prior = 1.0 / static_cast<double>(std::max<std::size_t>(slots, 1));
  double load = 0;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    ExpectedShare& share = now[sessions[i].id].share;
    share.watch(seconds, scale * took[i]);
    load += share.value(prior);
  }
  sessions_ = std::move(now);
  other_.watch(seconds, busy - scale * all);
  return load + other_.value(0);
}

}  // namespace diaphane::render
