#include "renderd/serve/file_work.h"

#include <gtest/gtest.h>

#include <condition_variable>
#include <thread>

#include "renderd/schedule/round_robin.h"
#include "tests/support/renderd/fake_engine.h"

namespace diaphane::render {
namespace {

using namespace std::chrono_literals;

/// Makes a fixed number of pictures, each of which gives a fixed number of bytes at once, and some
/// at the end.
class FakeMaker final : public FileMaker {
 public:
  FakeMaker(int pictures, std::size_t bytes, std::size_t at_end)
      : pictures_(pictures), bytes_(bytes), at_end_(at_end) {}
  std::optional<FileStep> next() override {
    if (made == pictures_) return std::nullopt;
    return FileStep{std::make_shared<const v1::Scene>(), {16, 16}, 1, 0, false};
  }
  Result<std::string> take(const PictureRgb8&, std::uint64_t samples) override {
    EXPECT_EQ(samples, 1u);
    ++made;
    return text(bytes_);
  }
  Result<std::string> finish() override {
    if (fails) return fail(ErrorCode::kInternal, "It cannot be coded.");
    return text(at_end_);
  }
  double done() const override { return double(made) / pictures_; }

  std::atomic<int> made{0};
  bool fails = false;

 private:
  // No two positions hold the same text.
  std::string text(std::size_t bytes) {
    std::string out;
    while (out.size() < bytes) out += std::to_string(count_++) + ' ';
    out.resize(bytes);
    return out;
  }
  const int pictures_;
  const std::size_t bytes_, at_end_;
  int count_ = 0;
};

class Kept final : public FileSink {
 public:
  void progress(double done) override {
    const std::lock_guard lock(mutex_);
    EXPECT_GT(done, last_done);
    last_done = done;
    changed_.notify_all();
  }
  void part(std::uint64_t seq, std::string bytes, bool is_last) override {
    const std::lock_guard lock(mutex_);
    EXPECT_EQ(seq, parts + 1);
    EXPECT_LE(bytes.size(), kFilePartBytes);
    EXPECT_FALSE(last);
    parts = seq;
    file += bytes;
    last = is_last;
    changed_.notify_all();
  }
  void ended(const Error& error) override {
    const std::lock_guard lock(mutex_);
    why = error.message;
    changed_.notify_all();
  }
  bool wait(const std::function<bool()>& holds, std::chrono::milliseconds within = 60s) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, within, holds);
  }

  std::uint64_t parts = 0;
  std::string file, why;
  bool last = false;
  double last_done = 0;

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
};

struct FileWorkTest : testing::Test {
  std::shared_ptr<FileWork> work(std::unique_ptr<FakeMaker> made) {
    maker = made.get();
    return std::make_shared<FileWork>(runner, pool, std::make_shared<FakeRenderer>(device, nullptr),
                                      std::move(made), sink, [this](double seconds) {
                                        EXPECT_GE(seconds, 0);
                                        ++charged;
                                      });
  }
  std::shared_ptr<FakeDevice> device = std::make_shared<FakeDevice>();
  std::shared_ptr<Kept> sink = std::make_shared<Kept>();
  std::atomic<int> charged{0};
  FakeMaker* maker = nullptr;
  SystemClock clock;
  Runner runner{std::make_unique<RoundRobin>(), clock, Runner::Options{}};
  EncodePool pool{1};
};

TEST_F(FileWorkTest, DeliversWholeFileInOrder) {
  const auto file = work(std::make_unique<FakeMaker>(10, 1000, 2500));
  file->start();
  ASSERT_TRUE(sink->wait([&] { return sink->last; }));
  EXPECT_EQ(sink->file.size(), 12500u);
  EXPECT_EQ(sink->last_done, 1);
  EXPECT_EQ(charged, 10);
}

TEST_F(FileWorkTest, LimitsPartsInFlight) {
  const auto file = work(std::make_unique<FakeMaker>(1, 0, 20 * kFilePartBytes + 5));
  file->start();
  ASSERT_TRUE(sink->wait([&] { return sink->parts == kFilePartsInFlight; }));
  EXPECT_FALSE(sink->wait([&] { return sink->parts > kFilePartsInFlight; }, 50ms));
  file->taken(1'000'000);  // never sent
  EXPECT_EQ(sink->parts, kFilePartsInFlight);
  file->taken(3);
  file->taken(2);  // a late acknowledgement
  EXPECT_EQ(sink->parts, kFilePartsInFlight + 3);
  while (!sink->last) file->taken(sink->parts);
  EXPECT_EQ(sink->parts, 21u);
  EXPECT_EQ(sink->file.size(), 20 * kFilePartBytes + 5);
  EXPECT_EQ(sink->file.substr(0, 6), "0 1 2 ");
}

// If a viewer takes nothing, no more is made than the limit.
TEST_F(FileWorkTest, RenderingWaitsForASlowViewer) {
  constexpr std::size_t kBytes = std::size_t{3} << 20;
  const auto file = work(std::make_unique<FakeMaker>(20, kBytes, 0));
  file->start();
  ASSERT_TRUE(sink->wait([&] { return sink->parts == kFilePartsInFlight; }));
  std::this_thread::sleep_for(50ms);
  EXPECT_LT(maker->made, 6);
  while (!sink->wait([&] { return sink->last; }, 1ms)) file->taken(sink->parts);
  EXPECT_EQ(maker->made, 20);
  EXPECT_EQ(sink->file.size(), 20 * kBytes);
}

TEST_F(FileWorkTest, StopEndsRenderingAndMessages) {
  device->seconds_per_megapixel = 40;  // 10 ms per picture
  auto file = work(std::make_unique<FakeMaker>(1000, 100, 0));
  file->start();
  ASSERT_TRUE(sink->wait([&] { return sink->last_done > 0; }));
  file->stop();
  const std::weak_ptr<FileWork> left = file;
  file.reset();
  for (int i = 0; i < 3000 && !left.expired(); ++i) std::this_thread::sleep_for(1ms);
  EXPECT_TRUE(left.expired()) << "and nothing of it is kept";
  const auto samples = device->samples.load();
  std::this_thread::sleep_for(50ms);
  EXPECT_EQ(device->samples, samples);
  EXPECT_EQ(sink->parts, 0u);
  EXPECT_EQ(sink->why, "");
}

TEST_F(FileWorkTest, ReportsWhyRenderingOrEncodingFailed) {
  device->refuse_scenes = true;
  work(std::make_unique<FakeMaker>(3, 10, 0))->start();
  ASSERT_TRUE(sink->wait([&] { return !sink->why.empty(); }));
  EXPECT_EQ(sink->why, "No memory for a picture of this size.");
  device->refuse_scenes = false;
  sink = std::make_shared<Kept>();
  auto made = std::make_unique<FakeMaker>(3, 10, 0);
  made->fails = true;
  const auto file = work(std::move(made));
  file->start();
  ASSERT_TRUE(sink->wait([&] { return !sink->why.empty(); }));
  EXPECT_EQ(sink->why, "It cannot be coded.");
  EXPECT_EQ(sink->parts, 0u);
}

}  // namespace
}  // namespace diaphane::render
