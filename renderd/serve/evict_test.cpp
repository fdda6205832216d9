#include "renderd/serve/evict.h"

#include <gtest/gtest.h>

#include <vector>

#include "common/visitor_share.h"

namespace diaphane::render {
namespace {

using namespace std::chrono_literals;

const SlotHolder kHolder{.id = "holder", .age = 100s};
const SlotHolder kReloading{.id = "reloading", .abandoned_for = 2s, .age = 100s};
const SlotHolder kVisitor{.id = "visitor", .visitor = true, .age = 5s};
const SlotHolder kOlderVisitor{.id = "older visitor", .visitor = true, .age = 50s};
const SlotHolder kCamera{.id = "camera", .visitor = true, .free_camera = true, .age = 1s};
const SlotHolder kGoneVisitor{.id = "gone", .visitor = true, .abandoned_for = 1s, .age = 9s};

TEST(Evict, EvictsVisitorsFirstInOrderOfLeastLoss) {
  std::vector<SlotHolder> holders{kHolder, kReloading,   kVisitor,
                                  kCamera, kGoneVisitor, kOlderVisitor};
  for (const char* next : {"gone", "camera", "older visitor", "visitor", "reloading"}) {
    const auto chosen = to_evict(holders, false);
    ASSERT_EQ(chosen, next);
    std::erase_if(holders, [&](const SlotHolder& one) { return one.id == *chosen; });
  }
  EXPECT_FALSE(to_evict(holders, false)) << "an active account holder is not evicted";
}

TEST(Evict, VisitorEvictsOnlyVisitorsWhoLeft) {
  EXPECT_FALSE(to_evict(std::vector{kHolder, kReloading, kVisitor, kCamera}, true));
  EXPECT_EQ(to_evict(std::vector{kReloading, kVisitor, kGoneVisitor}, true), "gone");
}

TEST(Evict, VisitorShareReservesTheLastSlotsForAccounts) {
  EXPECT_EQ(visitor_slots(0, 25), 0U);
  EXPECT_EQ(visitor_slots(1, 25), 0U);
  EXPECT_EQ(visitor_slots(2, 25), 1U);
  EXPECT_EQ(visitor_slots(8, 25), 2U);
  EXPECT_EQ(visitor_slots(64, 25), 16U);
  EXPECT_EQ(visitor_slots(8, 0), 0U);
  EXPECT_EQ(visitor_slots_of_worker(1, 25), 1U) << "a fleet of workers with one slot";
  EXPECT_EQ(visitor_slots_of_worker(8, 25), 2U);
  EXPECT_EQ(visitor_slots_of_worker(8, 0), 0U);
  EXPECT_EQ(visitor_slots_of_source(0), 0U);
  EXPECT_EQ(visitor_slots_of_source(1), 1U);
  EXPECT_EQ(visitor_slots_of_source(2), 2U);
  EXPECT_EQ(visitor_slots_of_source(8), 4U) << "one link never takes the whole share";
}

}  // namespace
}  // namespace diaphane::render
