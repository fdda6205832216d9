#pragma once

#include <mutex>
#include <optional>

#include "common/clock.h"

namespace diaphane::render {

/// The system's clock, which a test can hold. A busy machine then cannot end a gesture by delaying
/// its next input.
class HeldClock final : public Clock {
 public:
  std::chrono::steady_clock::time_point now() const override {
    const std::lock_guard lock(mutex_);
    return held_.value_or(std::chrono::steady_clock::now());
  }
  std::chrono::system_clock::time_point wall() const override {
    return std::chrono::system_clock::now();
  }
  void hold() {
    const std::lock_guard lock(mutex_);
    held_ = std::chrono::steady_clock::now();
  }
  void release() {
    const std::lock_guard lock(mutex_);
    held_.reset();
  }

 private:
  mutable std::mutex mutex_;
  std::optional<std::chrono::steady_clock::time_point> held_;
};

}  // namespace diaphane::render
