#pragma once

#include <chrono>
#include <functional>
#include <thread>

namespace diaphane::render {

/// For tests: whether it comes to hold; false when it has not for as long as `within`.
inline bool eventually(const std::function<bool()>& holds,
                       std::chrono::milliseconds within = std::chrono::seconds(10)) {
  const auto end = std::chrono::steady_clock::now() + within;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace diaphane::render
