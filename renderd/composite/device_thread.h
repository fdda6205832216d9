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

/// A device of this process that helps to render pictures of other devices. It has one thread,
/// which takes turns between the pictures that need more samples.
class DeviceThread {
 public:
  DeviceThread();
  /// Its assistants do nothing afterwards.
  ~DeviceThread();
  DeviceThread(const DeviceThread&) = delete;
  DeviceThread& operator=(const DeviceThread&) = delete;

  /// Makes an assistant that renders with `renderer`, which must belong to this device. The thread
  /// must outlive the assistant.
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
