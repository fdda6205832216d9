#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace diaphane::api {

/// A thread that runs a task periodically, and immediately when woken. Exceptions are logged.
class Periodic {
 public:
  Periodic(std::string name, std::chrono::milliseconds period, std::function<void()> work);
  ~Periodic();
  void wake();

 private:
  void run();
  const std::string name_;
  const std::chrono::milliseconds period_;
  const std::function<void()> work_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool woken_ = false;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace diaphane::api
