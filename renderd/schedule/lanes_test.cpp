#include "renderd/schedule/lanes.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <latch>

namespace diaphane::render {
namespace {

TEST(Lanes, EachPieceIsDoneOnceAndAllAreDoneAtTheEnd) {
  Lanes lanes(4);
  for (const std::size_t count : {1, 2, 3, 4, 9, 2, 1, 7}) {
    std::array<std::atomic<int>, 9> calls{};
    lanes.run(count, [&](std::size_t i) { ++calls[i]; });
    for (std::size_t i = 0; i < calls.size(); ++i) EXPECT_EQ(calls[i], i < count ? 1 : 0);
  }
}

TEST(Lanes, PiecesRunAtOnce) {
  Lanes lanes(3);
  std::latch all(3);  // none passes before all have come
  lanes.run(3, [&](std::size_t) { all.arrive_and_wait(); });
}

TEST(Lanes, OneLaneIsTheCallersThread) {
  Lanes lanes(1);
  const auto caller = std::this_thread::get_id();
  lanes.run(5, [&](std::size_t) { EXPECT_EQ(std::this_thread::get_id(), caller); });
}

}  // namespace
}  // namespace diaphane::render
