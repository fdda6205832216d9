#include "api/shared/periodic.h"

#include <exception>

#include "common/log.h"

namespace diaphane::api {

Periodic::Periodic(std::string name, std::chrono::milliseconds period, std::function<void()> work)
    : name_(std::move(name)), period_(period), work_(std::move(work)), thread_([this] { run(); }) {}

Periodic::~Periodic() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Periodic::wake() {
  {
    const std::lock_guard lock(mutex_);
    woken_ = true;
  }
  changed_.notify_all();
}

void Periodic::run() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    woken_ = false;
    lock.unlock();
    try {
      work_();
    } catch (const std::exception& thrown) {
      log::error("background task failed", {{"work", name_}, {"reason", log::describe(thrown)}});
    }
    lock.lock();
    changed_.wait_for(lock, period_, [this] { return stopping_ || woken_; });
  }
}

}  // namespace diaphane::api
