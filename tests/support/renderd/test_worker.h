#pragma once

#include <gtest/gtest.h>
#include <prometheus/registry.h>
#include <stdlib.h>

#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <optional>

#include "common/ids.h"
#include "renderd/scene/presets.h"
#include "renderd/serve/render_worker.h"
#include "tests/support/renderd/fake_engine.h"

namespace diaphane::render {

/// A clock that a test advances while other threads read it.
class SharedManualClock final : public Clock {
 public:
  std::chrono::steady_clock::time_point now() const override {
    const std::lock_guard lock(mutex_);
    return clock_.now();
  }
  std::chrono::system_clock::time_point wall() const override {
    const std::lock_guard lock(mutex_);
    return clock_.wall();
  }
  void advance(std::chrono::nanoseconds by) {
    const std::lock_guard lock(mutex_);
    clock_.advance(by);
  }

 private:
  mutable std::mutex mutex_;
  ManualClock clock_;
};

/// A volume store in a temporary directory that contains a ball of "bone" in air.
class TestStore {
 public:
  TestStore() {
    char name[] = "/tmp/renderd-test-XXXXXX";
    path = mkdtemp(name);
  }
  ~TestStore() { std::filesystem::remove_all(path); }

  /// With more than one phase, the ball shrinks from phase to phase.
  std::string add_ball(std::uint32_t side = 24, std::uint32_t phases = 1) {
    volume::Volume volume;
    volume.header.size = {side, side, side};
    volume.header.spacing = {4, 4, 4};
    volume.header.modality = volume::Modality::kCt;
    for (std::uint32_t phase = 0; phase < phases; ++phase) {
      const double radius = 0.35 * side * (phases - phase) / phases;
      add_ball_to(volume.voxels, side, radius);
      if (phases > 1) {
        volume.header.phases.push_back({volume::PhaseKind::kCycle, 100.0 * phase / phases});
      }
    }
    volume::measure(volume);
    const std::string id = new_id();
    const auto written = volume::write(volume, path + "/" + id);
    EXPECT_TRUE(written) << written.error().message;
    return id;
  }

  std::string path;

 private:
  static void add_ball_to(std::vector<std::int16_t>& voxels, std::uint32_t side, double radius) {
    const double centre = side / 2.0;
    for (std::uint32_t z = 0; z < side; ++z) {
      for (std::uint32_t y = 0; y < side; ++y) {
        for (std::uint32_t x = 0; x < side; ++x) {
          const double r = std::hypot(x - centre, y - centre, z - centre);
          voxels.push_back(r < radius ? 1200 : -1000);
        }
      }
    }
  }
};

/// The messages that a viewer received, and how the connection ended.
class Inbox {
 public:
  void put(const std::string& bytes) {
    const std::lock_guard lock(mutex_);
    v1::ServerMessage message;
    EXPECT_TRUE(message.ParseFromString(bytes));
    messages_.push_back(std::move(message));
    arrived_.notify_all();
  }
  void end(const Error& why) {
    const std::lock_guard lock(mutex_);
    ended_ = why;
    arrived_.notify_all();
  }

  using Test = std::function<bool(const v1::ServerMessage&)>;
  /// Returns the next message that passes `test`, and discards those before it.
  std::optional<v1::ServerMessage> next(
      const Test& test, std::chrono::milliseconds within = std::chrono::seconds(60)) {
    std::unique_lock lock(mutex_);
    std::optional<v1::ServerMessage> found;
    arrived_.wait_for(lock, within, [&] {
      for (; seen_ < messages_.size(); ++seen_) {
        if (test(messages_[seen_])) {
          found = messages_[seen_++];
          return true;
        }
      }
      return ended_.has_value();
    });
    return found;
  }
  std::optional<v1::ServerMessage> next_of(
      v1::ServerMessage::BodyCase kind,
      std::chrono::milliseconds within = std::chrono::seconds(60)) {
    return next([kind](const auto& message) { return message.body_case() == kind; }, within);
  }
  std::optional<Error> ended(std::chrono::milliseconds within = std::chrono::seconds(60)) {
    std::unique_lock lock(mutex_);
    arrived_.wait_for(lock, within, [&] { return ended_.has_value(); });
    return ended_;
  }
  std::vector<v1::ServerMessage> all() {
    const std::lock_guard lock(mutex_);
    return messages_;
  }
  std::size_t count(v1::ServerMessage::BodyCase kind) {
    const std::lock_guard lock(mutex_);
    return static_cast<std::size_t>(
        std::count_if(messages_.begin(), messages_.end(),
                      [&](const auto& message) { return message.body_case() == kind; }));
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<v1::ServerMessage> messages_;
  std::size_t seen_ = 0;
  std::optional<Error> ended_;
};

/// A connection that stores what the session sends.
struct Link final : ClientLink {
  Inbox inbox;
  void send(std::string message) override { inbox.put(message); }
  void finish(const Error& why) override { inbox.end(why); }
};

inline v1::ClientMessage hello_message(std::uint32_t side = 64) {
  v1::ClientMessage message;
  v1::Hello& hello = *message.mutable_hello();
  hello.set_protocol(1);
  hello.add_codecs(v1::JPEG);
  hello.mutable_viewport()->set_width(side);
  hello.mutable_viewport()->set_height(side);
  return message;
}

inline v1::ClientMessage ack_message(std::uint64_t seq) {
  v1::ClientMessage message;
  message.mutable_ack()->set_seq(seq);
  return message;
}

inline v1::ClientMessage scene_message(std::uint64_t seq, const v1::Scene& scene) {
  v1::ClientMessage message;
  message.mutable_scene()->set_input_seq(seq);
  *message.mutable_scene()->mutable_scene() = scene;
  return message;
}

/// Returns the scene from a slightly moved camera.
inline v1::Scene turned(v1::Scene scene, double by) {
  scene.mutable_camera()->mutable_eye()->set_x(scene.camera().eye().x() + by);
  return scene;
}

inline v1::Open open_message(const std::string& session, const std::string& volume,
                             const std::string& participant = {}) {
  v1::Open open;
  open.set_session_id(session);
  open.set_volume_id(volume);
  open.set_placement(1);
  open.set_participant(participant);
  open.set_viewer(participant.empty() ? v1::VIEWER_OWNER : v1::VIEWER_LIVE_GUEST);
  return open;
}

/// One viewer's end of a session.
struct TestViewer {
  std::shared_ptr<Link> link = std::make_shared<Link>();
  std::optional<Attachment> attachment;

  void say(const v1::ClientMessage& message) { attachment->receive(message.SerializeAsString()); }
  std::optional<v1::Problem> problem() {
    const auto message = link->inbox.next_of(v1::ServerMessage::kProblem);
    return message ? std::optional(message->problem()) : std::nullopt;
  }
};

/// A worker with a device that tests can slow down, and with its own store.
struct WorkerTest : testing::Test {
  void start_worker() {
    options.volume_dir = store.path;
    worker.reset();
    worker = std::make_unique<RenderWorker>(options, std::make_unique<FakeEngine>(device), metrics,
                                            clock);
  }
  /// Opens the session and sends the greeting. Returns the session's configuration.
  v1::Config enter(TestViewer& viewer, const v1::Open& open) {
    viewer.attachment.emplace(*worker->host().open(open, viewer.link));
    viewer.say(hello_message());
    const auto config = viewer.link->inbox.next_of(v1::ServerMessage::kConfig);
    EXPECT_TRUE(config);
    return config ? config->config() : v1::Config();
  }

  TestStore store;
  std::shared_ptr<FakeDevice> device = std::make_shared<FakeDevice>();
  prometheus::Registry registry;
  Metrics metrics{registry};
  SystemClock clock;
  RenderWorker::Options options;
  std::unique_ptr<RenderWorker> worker;
};

}  // namespace diaphane::render
