#include "renderd/session/flight.h"

#include <gtest/gtest.h>

#include <random>

namespace diaphane::render {
namespace {

TEST(FlightWindow, LimitsFramesInFlightToTwo) {
  FlightWindow window;
  std::mt19937 random(7);
  std::uint64_t reserved = 0;
  std::uint64_t sent = 0;
  std::uint64_t acknowledged = 0;
  for (int i = 0; i < 10000; ++i) {
    switch (random() % 4) {
      case 0:
        if (window.reserve()) ++reserved;
        break;
      case 1:
        if (reserved > 0) {
          --reserved;
          sent = window.depart();
        }
        break;
      case 2:
        if (reserved > 0) {
          --reserved;
          window.release();
        }
        break;
      default: {
        const std::uint64_t seq = random() % (sent + 3);
        if (window.acknowledge(seq)) acknowledged = seq;
      }
    }
    ASSERT_LE(reserved + sent - acknowledged, FlightWindow::kLimit);
    ASSERT_EQ(window.room(), reserved + sent - acknowledged < FlightWindow::kLimit);
  }
}

TEST(FlightWindow, IgnoresAcknowledgementOfUnsentFrames) {
  FlightWindow window;
  ASSERT_TRUE(window.reserve());
  EXPECT_EQ(window.depart(), 1U);
  ASSERT_TRUE(window.reserve());
  EXPECT_EQ(window.depart(), 2U);
  EXPECT_FALSE(window.acknowledge(99));
  EXPECT_FALSE(window.acknowledge(0));
  EXPECT_FALSE(window.room());
  EXPECT_TRUE(window.acknowledge(2));  // acknowledges both frames
  EXPECT_FALSE(window.acknowledge(1));
  EXPECT_TRUE(window.reserve());
  EXPECT_TRUE(window.reserve());
  EXPECT_FALSE(window.reserve());
}

}  // namespace
}  // namespace diaphane::render
