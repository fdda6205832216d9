#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
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
  /// Ends the thread. Its assistants do nothing afterwards.
  ~DeviceThread();
  DeviceThread(const DeviceThread&) = delete;
  DeviceThread& operator=(const DeviceThread&) = delete;

  /// Makes an assistant that renders with `renderer`, which must belong to this device, and copies
  /// of volumes for `device`. The thread must outlive the assistant.
  std::unique_ptr<Assistant> assistant(std::unique_ptr<FrameRenderer> renderer, std::size_t device);
  /// Sets `needed`: the assistants are lost while the function is true, and come back some time
  /// after it has become false. Null: the device is never needed. The previous function is never
  /// called after this returns.
  void keep_for_own(std::function<bool()> needed);

 private:
  class Job;
  class JobAssistant;

  void run();
  /// Returns whether the device's own pictures need the device now.
  bool needed();
  /// Returns whether they need the device, or needed it a moment ago, so that a brief pause of a
  /// picture does not make helpers leave and return.
  bool kept();
  void add(std::shared_ptr<Job> job);
  void wake();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::list<std::shared_ptr<Job>> jobs_;
  std::uint64_t wakes_ = 0;
  std::mutex needed_mutex_;
  std::function<bool()> needed_;
  std::atomic<bool> away_{false};
  std::chrono::steady_clock::time_point needed_until_{};  ///< used by the thread only
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace diaphane::render
