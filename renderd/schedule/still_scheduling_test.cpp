#include "renderd/schedule/still_scheduling.h"

#include <gtest/gtest.h>

namespace diaphane::render {
namespace {

TEST(StillScheduling, FileDoesNotRunWhileASessionMoves) {
  EXPECT_EQ(still_share(StillRank::kFile, 1), 0);
  EXPECT_FALSE(still_may_run(StillRank::kFile, 1));
  EXPECT_TRUE(still_may_run(StillRank::kFile, 0));
  for (const StillRank rank : {StillRank::kAwaited, StillRank::kBackground}) {
    EXPECT_TRUE(still_may_run(rank, 3));
    EXPECT_GT(still_share(rank, 3), 0);
  }
}

TEST(StillScheduling, ShareFallsWithRankAndMovingSessions) {
  EXPECT_GT(still_share(StillRank::kAwaited, 0), still_share(StillRank::kBackground, 0));
  EXPECT_GT(still_share(StillRank::kAwaited, 0), still_share(StillRank::kAwaited, 1));
}

// While sessions refine their pictures without a pause, a file gets half of the time in the long
// run, however long its samples take.
TEST(StillScheduling, FilePaysBackTheTimeOfALongSample) {
  for (const double sample : {0.01, 0.1, 0.9}) {
    double due = 0, busy = 0, files = 0;
    while (busy < 1000) {
      const double quantum = 0.008;
      busy += quantum;
      due += still_share(StillRank::kFile, 0) * quantum;
      if (due < 0.03) continue;
      busy += sample;
      files += sample;
      due = still_due_after(StillRank::kFile, due + still_share(StillRank::kFile, 0) * sample,
                            sample);
    }
    EXPECT_NEAR(files / busy, 0.5, 0.005) << sample;
  }
}

TEST(StillScheduling, FinishesAtTheSampleErrorOrTimeLimitButNotWithoutSamples) {
  const double never = 0;
  EXPECT_FALSE(still_is_rendered({9, 10, 0.2, never, false}));
  EXPECT_TRUE(still_is_rendered({10, 10, 0.2, never, false}));
  EXPECT_FALSE(still_is_rendered({4, 10, 0.2, 0.1, false}));
  EXPECT_TRUE(still_is_rendered({4, 10, 0.1, 0.1, false}));
  EXPECT_FALSE(still_is_rendered({4, 10, 0, never, false}));
  EXPECT_TRUE(still_is_rendered({1, 10, 0.2, never, true}));
  EXPECT_FALSE(still_is_rendered({0, 10, 0, 0.1, true}));
}

}  // namespace
}  // namespace diaphane::render
