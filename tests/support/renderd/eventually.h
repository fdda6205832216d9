#pragma once

#include <chrono>
#include <functional>
#include <thread>

namespace diaphane::render {

/// Waits in a test until `holds` returns true. Returns false if it does not within `within`.
inline bool eventually(const std::function<bool()>& holds,
                       std::chrono::milliseconds within = std::chrono::seconds(60)) {
  const auto end = std::chrono::steady_clock::now() + within;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace diaphane::render
