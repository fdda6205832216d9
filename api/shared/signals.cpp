#include "api/shared/signals.h"

#include <utility>

namespace diaphane::api {

void Signals::subscribe(Signal signal, Listener listener) {
  const std::lock_guard lock(mutex_);
  listeners_[static_cast<std::size_t>(signal)].push_back(std::move(listener));
}

void Signals::raise(Signal signal) const {
  // The listeners are copied, because one of them may raise another signal.
  const auto listeners = [&] {
    const std::lock_guard lock(mutex_);
    return listeners_[static_cast<std::size_t>(signal)];
  }();
  for (const Listener& listener : listeners) listener();
}

}  // namespace diaphane::api
