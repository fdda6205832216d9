#pragma once

#include <atomic>
#include <condition_variable>
#include <list>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "renderd/composite/assistant.h"

namespace diaphane::render {

/// A device of this process that renders for others' pictures: one thread, which takes turns
/// between the pictures that want more.
class DeviceThread {
 public:
  DeviceThread();
  /// Its assistants do nothing from then on.
  ~DeviceThread();
  DeviceThread(const DeviceThread&) = delete;
  DeviceThread& operator=(const DeviceThread&) = delete;

  /// Renders with `renderer`, which is of this device. The thread outlives the assistant.
  std::unique_ptr<Assistant> assistant(std::unique_ptr<FrameRenderer> renderer);

 private:
  class Job;
  class JobAssistant;

  void run();
  void add(std::shared_ptr<Job> job);
  void wake();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::list<std::shared_ptr<Job>> jobs_;
  std::uint64_t wakes_ = 0;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace diaphane::render
