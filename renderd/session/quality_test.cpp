// Estimate and quality steps on a simulated link without a clock.

#include "renderd/session/quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>
#include <vector>

namespace diaphane::render {
namespace {

using Time = LinkEstimate::Time;
constexpr double kMbit = 1e6 / 8;  // bytes per second
constexpr Canvas k720p{1280, 720};

Time at(double seconds) {
  return Time{} + std::chrono::hours(1) +
         std::chrono::duration_cast<Time::duration>(std::chrono::duration<double>(seconds));
}

/// A pipe with an unlimited queue, and a viewer who acknowledges complete messages.
struct Pipe {
  std::function<double(double)> rate;  ///< bytes per second at a given time
  double round_trip = 0;               ///< of an empty message, in seconds
  double jitter = 0;                   ///< maximum delay of an acknowledgement

  double free_at = 0;
  double last = 0;

  /// Returns when a message sent now is acknowledged.
  double carry(double now, double bytes, std::mt19937& random) {
    free_at = std::max(free_at, now + round_trip / 2);
    for (double left = bytes; left > 0;) {  // in steps, because the rate may change
      const double step = std::min(left, rate(free_at) * 0.002);
      free_at += step / rate(free_at);
      left -= step;
    }
    const double late = jitter * std::uniform_real_distribution<>(0, 1)(random);
    last = std::max(last, free_at + round_trip / 2 + late);
    return last;
  }
};

struct Drag {
  struct Sent {
    double at, bytes, age;  ///< age: until its acknowledgement
    double scale;
  };
  std::vector<Sent> sent;

  double oldest(double from, double to) const {
    double age = 0;
    for (const Sent& one : sent) {
      if (one.at >= from && one.at < to) age = std::max(age, one.age);
    }
    return age;
  }
  double bytes_per_second(double from, double to) const {
    double bytes = 0;
    for (const Sent& one : sent) {
      if (one.at >= from && one.at < to) bytes += one.bytes;
    }
    return bytes / (to - from);
  }
  int size_changes(double from, double to) const {
    int changes = 0;
    double scale = 0;
    for (const Sent& one : sent) {
      if (one.at < from || one.at >= to) continue;
      changes += scale != 0 && one.scale != scale;
      scale = one.scale;
    }
    return changes;
  }
  double last_scale() const { return sent.back().scale; }
};

/// Simulates a drag for `seconds`. Every 1/60 s, a picture is sent if the window has room. Its size
/// is about the limit, or that of a good picture.
Drag drag(Pipe pipe, double seconds, v1::Codec codec = v1::H264, double good_bits = 0.4) {
  LinkEstimate link;
  QualitySteps steps;
  Drag run;
  std::mt19937 random(5);
  struct Ack {
    std::uint64_t seq;
    double at;
  };
  std::vector<Ack> acks;
  std::size_t heard = 0;
  std::uint64_t seq = 0;
  double next_picture = 0;
  for (double now = 0; now < seconds; now += 0.001) {
    bool looked = false;
    while (heard < acks.size() && acks[heard].at <= now) {
      link.acknowledged(acks[heard].seq, at(acks[heard].at));
      ++heard;
      looked = true;
    }
    if (now < next_picture && !looked) continue;
    const QualityPlan& plan = steps.update(link, k720p, codec, at(now));
    if (now < next_picture) continue;
    const std::uint64_t frames = acks.size() - heard;
    if (frames >= plan.window_frames || link.bytes_in_flight() >= plan.window_bytes) continue;
    const double pixels = plan.moving_scale * plan.moving_scale * 1280 * 720;
    const double most = plan.moving_bytes > 0 ? plan.moving_bytes : 40e3;
    const double spread = std::uniform_real_distribution<>(0.6, 1.1)(random);
    const double bytes = spread * std::min(most, pixels * good_bits / 8);
    link.sent(++seq, static_cast<std::size_t>(bytes), at(now));
    acks.push_back({seq, pipe.carry(now, bytes, random)});
    run.sent.push_back({now, bytes, acks.back().at - now, plan.moving_scale});
    next_picture = now + 1.0 / 60;
  }
  return run;
}

Pipe constant(double rate, double round_trip, double jitter = 0) {
  Pipe pipe;
  pipe.rate = [rate](double) { return rate; };
  pipe.round_trip = round_trip;
  pipe.jitter = jitter;
  return pipe;
}

struct LinkCase {
  double rate, round_trip, jitter;
};

class Links : public testing::TestWithParam<LinkCase> {};

// Age: the round trip, a window's slack and the time of one frame, with a margin for the estimate.
TEST_P(Links, BoundsTheFrameAgeAndUsesTheBandwidth) {
  const auto [rate, round_trip, jitter] = GetParam();
  const Drag run = drag(constant(rate, round_trip, jitter), 30);
  EXPECT_LT(run.oldest(3, 30), 1.1 * round_trip + jitter + 0.15);
  EXPECT_LT(run.oldest(0, 30), round_trip + jitter + 40e3 * 2 / rate + 0.1) << "at the beginning";
  const double used = run.bytes_per_second(5, 30);
  const double demand = 60 * 0.85 * 1280 * 720 * 0.4 / 8;  // a good picture each time
  EXPECT_GT(used, 0.6 * std::min(rate, demand));
  EXPECT_LE(run.size_changes(5, 30), 2) << "it flickers between sizes";
}

INSTANTIATE_TEST_SUITE_P(
    All, Links,
    testing::Values(LinkCase{2 * kMbit, 0.1, 0}, LinkCase{2 * kMbit, 0.1, 0.02},
                    LinkCase{20 * kMbit, 0.01, 0}, LinkCase{20 * kMbit, 0.01, 0.01},
                    LinkCase{8 * kMbit, 0.04, 0.005}, LinkCase{1000 * kMbit, 0.0005, 0.002},
                    LinkCase{5 * kMbit, 0.3, 0}),
    [](const auto& info) {
      const LinkCase& link = info.param;
      return std::to_string(int(link.rate / kMbit)) + "Mbit" +
             std::to_string(int(1000 * link.round_trip)) + "ms" +
             std::to_string(int(1000 * link.jitter)) + "jitter";
    });

TEST(Quality, FollowsATenfoldBandwidthDropAndItsEnd) {
  Pipe pipe = constant(0, 0.02);
  pipe.rate = [](double now) { return (now > 10 && now < 20 ? 2 : 20) * kMbit; };
  const Drag run = drag(pipe, 30);
  EXPECT_LT(run.oldest(9, 12), 1.0) << "data in flight when the bandwidth fell";
  EXPECT_LT(run.oldest(12, 20), 0.25);
  EXPECT_LT(run.oldest(21, 30), 0.2);
  EXPECT_GT(run.bytes_per_second(12, 20), 0.6 * 2 * kMbit);
  EXPECT_GT(run.bytes_per_second(25, 30), 0.5 * 20 * kMbit);
  EXPECT_EQ(run.last_scale(), 1);
}

TEST(Quality, ReducesResolutionOnlyOnASlowLink) {
  EXPECT_LT(drag(constant(2 * kMbit, 0.1), 10).last_scale(), 1);
  EXPECT_GE(drag(constant(2 * kMbit, 0.1), 10).last_scale(), 0.5);
  EXPECT_LE(drag(constant(2 * kMbit, 0.1), 10, v1::JPEG).last_scale(), 0.375);
  EXPECT_EQ(drag(constant(100 * kMbit, 0.01), 10).last_scale(), 1);
  EXPECT_EQ(drag(constant(1000 * kMbit, 0.001), 10, v1::JPEG, 1).last_scale(), 1);
}

// The first acknowledgement waits for the decoder, and pictures of a slow device are far apart.
TEST(Quality, SlowStartAndRarePicturesDoNotLookLikeASlowLink) {
  for (const double round_trip : {0.002, 0.05, 0.15}) {
    LinkEstimate link;
    QualitySteps steps;
    double now = 0;
    for (std::uint64_t seq = 1; seq <= 8; ++seq, now += 1) {
      const QualityPlan& plan = steps.update(link, k720p, v1::H264, at(now));
      if (seq > 1) {
        EXPECT_GE(plan.settled_bytes, 60'000U) << round_trip << ", " << seq;
        EXPECT_GE(plan.moving_bytes, 8'000U) << round_trip << ", " << seq;
      }
      const std::size_t bytes = std::min(seq == 1 ? 3'000U : 70'000U, plan.settled_bytes - 1);
      link.sent(seq, bytes, at(now));
      const double decoder = seq == 1 ? 1.5 : 0;
      link.acknowledged(seq, at(now + decoder + round_trip + double(bytes) / (20 * kMbit)));
      now += decoder;
    }
    EXPECT_GE(link.bytes_per_second(at(now)), 10 * kMbit) << round_trip;
  }
}

// A viewer who acknowledges nothing gets no more than the window, however fast they were.
TEST(Quality, DetectsStalledLinkWithoutAcknowledgements) {
  LinkEstimate link;
  double now = 0;
  for (std::uint64_t seq = 1; seq <= 50; ++seq, now += 0.03) {
    link.sent(seq, 50000, at(now));
    link.acknowledged(seq, at(now + 0.01));
  }
  const double before = link.bytes_per_second(at(now));
  EXPECT_GT(before, 4e6);
  link.sent(51, 50000, at(now));
  EXPECT_EQ(link.bytes_per_second(at(now + 0.01)), before);
  EXPECT_LT(link.bytes_per_second(at(now + 1)), 60000);
}

TEST(Quality, IgnoresUnsentFramesAndClockJumps) {
  LinkEstimate link;
  link.acknowledged(5, at(0));
  EXPECT_FALSE(link.known());
  link.sent(1, 1000, at(1));
  link.acknowledged(7, at(1.1));
  EXPECT_FALSE(link.known());
  EXPECT_EQ(link.bytes_in_flight(), 1000U);
  link.acknowledged(1, at(0.5));  // before it was sent
  EXPECT_TRUE(link.known());
  EXPECT_EQ(link.bytes_in_flight(), 0U);
  link.acknowledged(1, at(2));
  EXPECT_EQ(link.bytes_in_flight(), 0U);
  link.sent(2, 1000, at(3));
  link.acknowledged(2, at(3600));  // the machine was suspended
  double now = 3601;
  for (std::uint64_t seq = 3; seq < 60; ++seq, now += 0.03) {
    link.sent(seq, 40000, at(now));
    link.acknowledged(seq, at(now + 0.02));
  }
  EXPECT_GT(link.bytes_per_second(at(now)), 1.5e6) << "forgotten within seconds";
  EXPECT_TRUE(std::isfinite(link.bytes_per_second(at(now))));
}

TEST(Quality, LimitsTheWindowOfAnInstantAcknowledger) {
  LinkEstimate link;
  QualitySteps steps;
  for (std::uint64_t seq = 1; seq < 1000; ++seq) {
    link.sent(seq, 100000, at(0.01 * double(seq)));
    link.acknowledged(seq, at(0.01 * double(seq)));
    const QualityPlan& plan = steps.update(link, k720p, v1::H264, at(0.01 * double(seq)));
    ASSERT_LE(plan.window_bytes, 8U << 20);
    ASSERT_LE(plan.window_frames, 12U);
    ASSERT_GE(plan.moving_bytes, 1500U);
  }
}

}  // namespace
}  // namespace diaphane::render
