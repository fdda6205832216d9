#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "common/clock.h"
#include "renderd/session/view_request.h"

namespace diaphane::render {

/// The viewer of one session of a runner. Keeps everything that it receives.
class TestClient final : public RenderClient {
 public:
  explicit TestClient(const Clock& clock, Canvas viewport = {100, 100}) : clock_(clock) {
    requested_.viewport = viewport;
    turn(1);
  }

  void turn(double angle) {
    const std::lock_guard lock(mutex_);
    auto scene = std::make_shared<v1::Scene>();
    scene->mutable_camera()->mutable_eye()->set_x(angle);
    requested_.scene = std::move(scene);
    requested_.last_input = clock_.now();
    ++requested_.input_seq;
    version_ = ++requested_.version;
  }
  /// The last input of a gesture.
  void turn_and_rest(double angle) {
    turn(angle);
    const std::lock_guard lock(mutex_);
    requested_.rest = true;
  }
  void show(bool visible) {
    const std::lock_guard lock(mutex_);
    requested_.visible = visible;
  }
  void no_room() {
    const std::lock_guard lock(mutex_);
    requested_.room = false;
  }
  void again() {
    const std::lock_guard lock(mutex_);
    requested_.picture_again = true;
  }

  bool with_spare_time() const override { return spare; }
  ViewRequest requested() override {
    const std::lock_guard lock(mutex_);
    ViewRequest requested = requested_;
    requested_.picture_again = false;
    return requested;
  }
  std::uint64_t version() const noexcept override { return version_; }
  void began(std::uint64_t epoch, const ViewRequest&) override { began_epoch = epoch; }
  void refused(const ViewRequest&, const Error& why) override {
    const std::lock_guard lock(mutex_);
    refusals.push_back(why);
  }
  void rendered(const Batch& batch) override {
    samples += batch.samples;
    const std::lock_guard lock(mutex_);
    charged_ += batch.seconds;
  }
  void picture(RenderedPicture picture) override {
    const std::lock_guard lock(mutex_);
    pictures_.push_back(std::move(picture));
  }
  void failed(const Error& why) override {
    const std::lock_guard lock(mutex_);
    failures.push_back(why);
  }

  std::vector<RenderedPicture> pictures() {
    const std::lock_guard lock(mutex_);
    return pictures_;
  }
  double charged() {
    const std::lock_guard lock(mutex_);
    return charged_;
  }
  std::size_t refusal_count() {
    const std::lock_guard lock(mutex_);
    return refusals.size();
  }
  std::size_t failure_count() {
    const std::lock_guard lock(mutex_);
    return failures.size();
  }

  std::atomic<std::uint64_t> samples{0};
  std::atomic<std::uint64_t> began_epoch{0};
  std::atomic<bool> spare{false};
  std::vector<Error> refusals;
  std::vector<Error> failures;

 private:
  const Clock& clock_;
  std::mutex mutex_;
  ViewRequest requested_;
  std::atomic<std::uint64_t> version_{0};
  std::vector<RenderedPicture> pictures_;
  double charged_ = 0;  // seconds
};

}  // namespace diaphane::render
