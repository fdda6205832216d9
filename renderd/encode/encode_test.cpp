#include <gtest/gtest.h>
#include <sys/resource.h>
#include <turbojpeg.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <latch>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "renderd/encode/encode_lane.h"
#include "tests/support/renderd/test_pictures.h"

namespace diaphane::render {
namespace {

struct Decoded {
  PictureRgb8 picture;
  int chroma = 0;
};

Decoded decode(const std::string& jpeg) {
  Decoded out;
  const tjhandle handle = tjInitDecompress();
  const auto* data = reinterpret_cast<const unsigned char*>(jpeg.data());
  int width = 0, height = 0, colorspace = 0;
  EXPECT_EQ(
      tjDecompressHeader3(handle, data, jpeg.size(), &width, &height, &out.chroma, &colorspace), 0);
  out.picture.size = {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
  out.picture.pixels.resize(std::size_t(3) * width * height);
  EXPECT_EQ(tjDecompress2(handle, data, jpeg.size(), out.picture.pixels.data(), width, 0, height,
                          TJPF_RGB, 0),
            0);
  tjDestroy(handle);
  return out;
}

TEST(JpegEncoder, RoundTripsWithSmallError) {
  auto encoder = make_encoder(v1::JPEG);
  ASSERT_TRUE(encoder);
  for (const Canvas size : {Canvas{64, 48}, Canvas{17, 33}, Canvas{320, 200}, Canvas{16, 16}}) {
    const PictureRgb8 picture = smooth_picture(size.width, size.height);
    const auto settled = (*encoder)->encode(picture, {Quality::kSettled, true});
    const auto moving = (*encoder)->encode(picture, {Quality::kMoving, false});
    ASSERT_TRUE(settled);
    ASSERT_TRUE(moving);
    EXPECT_EQ(settled->codec, v1::JPEG);
    EXPECT_TRUE(moving->key);
    const Decoded fine = decode(settled->data);
    const Decoded coarse = decode(moving->data);
    EXPECT_EQ(fine.picture.size, size);
    EXPECT_EQ(coarse.picture.size, size);
    EXPECT_EQ(fine.chroma, TJSAMP_444);
    EXPECT_EQ(coarse.chroma, TJSAMP_420);
    EXPECT_LT(rms(picture, fine.picture), 2.0);
    EXPECT_LT(rms(picture, coarse.picture), 12.0);
    EXPECT_LE(rms(picture, fine.picture), rms(picture, coarse.picture));
  }
}

TEST(JpegEncoder, RefusesImageWithWrongSize) {
  auto encoder = make_encoder(v1::JPEG);
  PictureRgb8 picture = smooth_picture(32, 32);
  picture.size.height = 33;
  EXPECT_FALSE((*encoder)->encode(picture, {}).has_value());
  EXPECT_FALSE((*encoder)->encode(PictureRgb8{}, {}).has_value());
  EXPECT_FALSE(make_encoder(v1::CODEC_UNSPECIFIED).has_value());
}

class Sink final : public FrameSink {
 public:
  Admitted admit(const FrameInfo& frame) override {
    const std::lock_guard lock(mutex);
    judged.push_back(frame.epoch);
    return {answer};
  }
  void coded(const FrameInfo& frame, CodedFrame, double) override {
    {
      const std::lock_guard lock(mutex);
      sent.push_back(frame.epoch);
    }
    if (after) after();
  }
  void dropped(const FrameInfo&, const Error&) override { ++failures; }

  std::mutex mutex;
  Admission answer = Admission::kGo;
  std::vector<std::uint64_t> judged;
  std::vector<std::uint64_t> sent;
  std::atomic<int> failures{0};
  std::function<void()> after;
};

RenderedPicture of_epoch(std::uint64_t epoch) {
  RenderedPicture rendered;
  rendered.info.epoch = epoch;
  rendered.info.samples = 1;
  rendered.picture = smooth_picture(16, 16);
  return rendered;
}

TEST(EncodePool, UrgentJobDoesNotWaitForALongJob) {
  EncodePool pool(1);
  std::latch long_one_begun(1), urgent_one_ended(1), all(1);
  pool.post(EncodePool::Urgency::kLater, [&] {
    long_one_begun.count_down();
    urgent_one_ended.wait();
    all.count_down();
  });
  long_one_begun.wait();
  pool.post(EncodePool::Urgency::kNow, [&] { urgent_one_ended.count_down(); });
  all.wait();
}

TEST(EncodePool, JobsOfEqualUrgencyStartInOrder) {
  for (const auto urgency :
       {EncodePool::Urgency::kNow, EncodePool::Urgency::kNowLarge, EncodePool::Urgency::kLater}) {
    std::vector<int> order;
    {
      EncodePool pool(1);
      for (int i = 0; i < 100; ++i) pool.post(urgency, [&order, i] { order.push_back(i); });
    }
    ASSERT_EQ(order.size(), 100U);
    EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
  }
}

TEST(EncodePool, RestsInProportionToTheWork) {
  using std::chrono::steady_clock;
  steady_clock::time_point begin, end, next;
  {
    EncodePool pool(1, 3);
    std::latch both_ended(2);
    pool.post(EncodePool::Urgency::kLater, [&] {
      begin = steady_clock::now();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      end = steady_clock::now();
      both_ended.count_down();
    });
    pool.post(EncodePool::Urgency::kLater, [&] {
      next = steady_clock::now();
      both_ended.count_down();
    });
    both_ended.wait();
  }
  EXPECT_GE(next - end, 3 * (end - begin));
}

TEST(EncodePool, DestructorDoesNotWaitForTheRest) {
  std::atomic<int> ran = 0;
  {
    EncodePool pool(1, 1e9);
    for (int i = 0; i < 3; ++i) {
      pool.post(EncodePool::Urgency::kLater, [&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        ++ran;
      });
    }
  }
  EXPECT_EQ(ran, 3);
}

TEST(EncodePool, DestructorRunsQueuedAndNewlyPostedJobs) {
  std::atomic<int> done{0};
  auto pool = std::make_unique<EncodePool>(2);
  EncodePool& there = *pool;  // valid until its destructor ends
  const auto other = [](EncodePool::Urgency urgency) {
    return urgency == EncodePool::Urgency::kNow ? EncodePool::Urgency::kLater
                                                : EncodePool::Urgency::kNow;
  };
  const std::function<void(EncodePool::Urgency, int)> hand_on = [&](auto urgency, int left) {
    there.post(urgency, [&, urgency, left] {
      ++done;
      if (left > 0) hand_on(other(urgency), left - 1);
    });
  };
  hand_on(EncodePool::Urgency::kNow, 50);
  hand_on(EncodePool::Urgency::kLater, 50);
  pool = nullptr;
  EXPECT_EQ(done, 102);
}

/// Posts jobs to a thread that is busy until start(), and notes the order in which they run.
class HeldPool {
 public:
  HeldPool() {
    pool_.post(EncodePool::Urgency::kNow, [this] { started_.wait(); });
  }
  void post(const char* name, std::size_t pixels) {
    // The pool has one thread for this urgency, so no lock is needed.
    pool_.post(
        EncodePool::Urgency::kNow, [this, name] { order_.emplace_back(name); }, pixels);
  }
  /// Starts the jobs, and returns their names once all have run.
  std::vector<std::string> run() {
    std::promise<void> last;
    pool_.post(
        EncodePool::Urgency::kNow, [&] { last.set_value(); }, 1000 * EncodePool::kSmallPixels);
    started_.count_down();
    last.get_future().wait();
    return order_;
  }

 private:
  std::latch started_{1};
  std::vector<std::string> order_;
  EncodePool pool_{1};  // destroyed first, because its jobs use the others
};

TEST(EncodePool, SmallImagesOvertakeLargerOnesPostedShortlyBefore) {
  HeldPool pool;
  pool.post("first large", EncodePool::kSmallPixels);
  pool.post("second large", EncodePool::kSmallPixels);
  pool.post("small", EncodePool::kSmallPixels / 20);
  EXPECT_EQ(pool.run(), (std::vector<std::string>{"small", "first large", "second large"}));
}

TEST(EncodePool, LargerImagesAreOvertakenOnlyBriefly) {
  HeldPool pool;
  pool.post("large", EncodePool::kSmallPixels);
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  pool.post("small", EncodePool::kSmallPixels / 20);
  EXPECT_EQ(pool.run(), (std::vector<std::string>{"large", "small"}));
}

TEST(EncodePool, DeferredWorkRunsAtALowerPriority) {
  int now = -1, later = -1;
  {
    EncodePool pool(1);
    pool.post(EncodePool::Urgency::kNow, [&] { now = getpriority(PRIO_PROCESS, 0); });
    pool.post(EncodePool::Urgency::kLater, [&] { later = getpriority(PRIO_PROCESS, 0); });
  }
  EXPECT_EQ(later, std::max(now, EncodePool::kLaterNice));
}

struct LaneTest : testing::Test {
  std::shared_ptr<Sink> sink = std::make_shared<Sink>();
  std::unique_ptr<EncodePool> pool = std::make_unique<EncodePool>(2);
  std::shared_ptr<EncodeLane> lane =
      std::make_shared<EncodeLane>(*pool, *make_encoder(v1::JPEG), sink);
  // The pool runs its queue before it ends.
  void settle() { pool = nullptr; }
};

TEST_F(LaneTest, SmallImageDoesNotWaitForALargeOne) {
  // The sink blocks the large picture until the small one of another session is encoded.
  struct Blocking final : FrameSink {
    Admitted admit(const FrameInfo&) override {
      begun.count_down();
      small_one_ended.wait();
      return {Admission::kDrop};
    }
    void coded(const FrameInfo&, CodedFrame, double) override {}
    void dropped(const FrameInfo&, const Error&) override {}
    std::latch begun{1}, small_one_ended{1};
  };
  pool = std::make_unique<EncodePool>(1);
  lane = std::make_shared<EncodeLane>(*pool, *make_encoder(v1::JPEG), sink);
  const auto blocking = std::make_shared<Blocking>();
  const auto other = std::make_shared<EncodeLane>(*pool, *make_encoder(v1::JPEG), blocking);
  RenderedPicture large = of_epoch(1);
  large.info.moving = true;
  large.picture = smooth_picture(1280, 720);
  other->submit(std::move(large));
  blocking->begun.wait();
  sink->after = [&] { blocking->small_one_ended.count_down(); };
  RenderedPicture small = of_epoch(1);
  small.info.moving = true;
  lane->submit(std::move(small));
  blocking->small_one_ended.wait();
  settle();
  EXPECT_EQ(sink->sent.size(), 1U);
}

TEST_F(LaneTest, LatestImageReplacesTheWaitingOne) {
  sink->answer = Admission::kWait;
  for (std::uint64_t epoch = 1; epoch <= 50; ++epoch) lane->submit(of_epoch(epoch));
  EXPECT_FALSE(lane->slot_free());
  EXPECT_EQ(lane->skipped(), 49U);
  {
    const std::lock_guard lock(sink->mutex);
    sink->answer = Admission::kGo;
  }
  lane->poke();
  settle();
  EXPECT_EQ(sink->sent, std::vector<std::uint64_t>{50});
  EXPECT_TRUE(lane->slot_free());
}

TEST_F(LaneTest, NeverEncodesOutdatedImage) {
  sink->answer = Admission::kDrop;
  lane->submit(of_epoch(1));
  settle();
  EXPECT_TRUE(sink->sent.empty());
  EXPECT_EQ(lane->skipped(), 1U);
  EXPECT_TRUE(lane->slot_free());
}

TEST_F(LaneTest, KeepsTheFrameOrderOnManyThreads) {
  for (std::uint64_t epoch = 1; epoch <= 300; ++epoch) lane->submit(of_epoch(epoch));
  settle();
  EXPECT_TRUE(std::is_sorted(sink->sent.begin(), sink->sent.end()));
  ASSERT_FALSE(sink->sent.empty());
  EXPECT_EQ(sink->sent.back(), 300U);
  EXPECT_EQ(sink->sent.size() + lane->skipped(), 300U);
}

TEST_F(LaneTest, EncodesImageSubmittedDuringEncoding) {
  sink->after = [this, once = true]() mutable {
    if (std::exchange(once, false)) lane->submit(of_epoch(2));
  };
  lane->submit(of_epoch(1));
  settle();
  EXPECT_EQ(sink->sent, (std::vector<std::uint64_t>{1, 2}));
}

TEST_F(LaneTest, BlockedSessionHoldsNoThread) {
  sink->answer = Admission::kWait;
  lane->submit(of_epoch(1));
  auto other_sink = std::make_shared<Sink>();
  auto other = std::make_shared<EncodeLane>(*pool, *make_encoder(v1::JPEG), other_sink);
  for (std::uint64_t epoch = 1; epoch <= 20; ++epoch) other->submit(of_epoch(epoch));
  settle();
  ASSERT_FALSE(other_sink->sent.empty());
  EXPECT_EQ(other_sink->sent.back(), 20U);
  EXPECT_TRUE(sink->sent.empty());
}

}  // namespace
}  // namespace diaphane::render
