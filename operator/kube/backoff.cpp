#include "operator/kube/backoff.h"

#include <algorithm>

namespace diaphane::kube {

std::chrono::milliseconds Backoff::next(Time now, double random) {
  const bool starts_over = !last_ || now - *last_ >= options_.forgotten;
  delay_ = starts_over ? options_.first : std::min(2 * delay_, options_.longest);
  last_ = now;
  return std::chrono::milliseconds(
      static_cast<std::int64_t>(static_cast<double>(delay_.count()) * (1 + random)));
}

}  // namespace diaphane::kube
