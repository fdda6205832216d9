#include "operator/kube/event_log.h"

#include <algorithm>

namespace diaphane::kube {

void EventLog::forget(Time now) {
  std::erase_if(written_, [&](const auto& one) { return now - one.second.last_seen > kForgotten; });
  std::erase_if(tokens_, [&](const auto& one) { return now - one.second.at > kBurst * kRefill; });
}

std::optional<EventLog::Write> EventLog::note(const Happened& what, Time now) {
  forget(now);
  const Key key{what.uid, what.reason, what.message};
  const auto found = written_.find(key);
  if (found != written_.end()) {
    Written& written = found->second;
    ++written.count;
    written.last_seen = now;
    if (now - written.last_written < kBetween) return std::nullopt;
    written.last_written = now;
    return Write{written.name, written.count};
  }
  const auto [at, is_new] = tokens_.try_emplace(what.uid, Tokens{kBurst, now});
  Tokens& tokens = at->second;
  const double gained = std::chrono::duration<double>(now - tokens.at) / kRefill;
  tokens.count = std::min<double>(kBurst, tokens.count + gained);
  tokens.at = now;
  if (tokens.count < 1) return std::nullopt;
  tokens.count -= 1;
  Written& written = written_[key];
  written = {what.name + "." + run_ + "." + std::to_string(++number_), 1, now, now, now};
  return Write{written.name, 1};
}

}  // namespace diaphane::kube
