#include "renderd/session/flight.h"

namespace diaphane::render {

bool FlightWindow::reserve() {
  if (!room()) return false;
  ++reserved_;
  return true;
}

void FlightWindow::release() {
  if (reserved_ > 0) --reserved_;
}

std::uint64_t FlightWindow::depart() {
  release();
  return ++sent_;
}

bool FlightWindow::acknowledge(std::uint64_t seq) {
  if (seq <= acknowledged_ || seq > sent_) return false;
  acknowledged_ = seq;
  return true;
}

}  // namespace diaphane::render
