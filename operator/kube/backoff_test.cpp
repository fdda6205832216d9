#include "operator/kube/backoff.h"

#include <gtest/gtest.h>

namespace diaphane::kube {
namespace {

using namespace std::chrono_literals;
using Time = Backoff::Time;

TEST(Backoff, DoublesUpToItsMaximum) {
  Backoff backoff;
  std::chrono::milliseconds expected = 800ms;
  Time now{};
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(backoff.next(now, 0), expected);
    expected = std::min(2 * expected, std::chrono::milliseconds(30s));
    now += 1s;
  }
  EXPECT_EQ(expected, 30s);
}

TEST(Backoff, ResetsAfterTwoMinutesWithoutFailure) {
  Backoff backoff;
  Time now{};
  for (int i = 0; i < 8; ++i) backoff.next(now, 0);
  EXPECT_EQ(backoff.next(now + 119s, 0), 30s);
  EXPECT_EQ(backoff.next(now + 119s + 120s, 0), 800ms);
}

TEST(Backoff, AddsJitterWithoutDoublingIt) {
  Backoff one;
  EXPECT_EQ(one.next({}, 0.5), 1200ms);
  // Jitter is not doubled with the delay.
  EXPECT_EQ(one.next({}, 0), 1600ms);
}

}  // namespace
}  // namespace diaphane::kube
