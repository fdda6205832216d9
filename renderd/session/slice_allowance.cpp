#include "renderd/session/slice_allowance.h"

#include <algorithm>

namespace diaphane::render {

void Bucket::refill(TimePoint now) {
  if (counted_at_) {
    const double seconds = std::chrono::duration<double>(now - *counted_at_).count();
    left_ = std::min(most_, left_ + std::max(0.0, seconds) * a_second_);
  }
  counted_at_ = now;
}

bool SliceAllowance::empty(TimePoint now) {
  pace_.refill(now);
  total_.refill(now);
  return pace_.empty() || total_.empty();
}

void SliceAllowance::take(double cost) {
  pace_.take(cost);
  total_.take(cost);
}

SliceAllowance& SliceAllowances::allowance_of(const std::string& participant) {
  const auto known = by_viewer_.find(participant);
  return known != by_viewer_.end()          ? known->second
         : by_viewer_.size() < kMostViewers ? by_viewer_[participant]
                                            : others_;
}

bool SliceAllowances::take(const std::string& participant, bool guest,
                           SliceAllowance::TimePoint now) {
  SliceAllowance& own = allowance_of(participant);
  if (own.empty(now) || (guest && guests_.empty(now))) return false;
  own.take();
  if (guest) guests_.take();
  return true;
}

void SliceAllowances::charge(const std::string& participant, bool guest, std::uint64_t samples) {
  const double cost = std::max(0.0, double(samples) / SliceAllowance::kSamplesPerToken - 1);
  allowance_of(participant).take(cost);
  if (guest) guests_.take(cost);
}

}  // namespace diaphane::render
