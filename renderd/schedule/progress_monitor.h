#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace diaphane::render {

/// Records the progress of the work on a device for a watchdog. Each piece of work occupies a
/// place, whose value changes whenever the work reports progress. Wait-free.
class ProgressMonitor {
 public:
  /// More than the number of pieces of work that ever run at once. Work that finds no free place is
  /// not watched.
  static constexpr std::size_t kPlaces = 64;

  /// Occupies a place for as long as it lives.
  class Work {
   public:
    explicit Work(ProgressMonitor& monitor) : monitor_(monitor) {
      for (auto& place : monitor_.places_) {
        std::uint64_t free = 0;
        if (place.compare_exchange_strong(free, monitor_.next())) {
          place_ = &place;
          return;
        }
      }
    }
    ~Work() {
      if (place_) *place_ = 0;
    }
    Work(const Work&) = delete;
    Work& operator=(const Work&) = delete;
    void heartbeat() {
      if (place_) place_->store(monitor_.next(), std::memory_order_relaxed);
    }

   private:
    ProgressMonitor& monitor_;
    std::atomic<std::uint64_t>* place_ = nullptr;
  };

  /// Returns 0 if the place is free. Otherwise the value changes whenever the work reports
  /// progress.
  std::uint64_t at(std::size_t place) const { return places_[place]; }

 private:
  std::uint64_t next() { return count_.fetch_add(1, std::memory_order_relaxed) + 1; }

  std::array<std::atomic<std::uint64_t>, kPlaces> places_{};
  std::atomic<std::uint64_t> count_{0};
};

}  // namespace diaphane::render
