#include "directory/lending.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

namespace diaphane::directory {
namespace {

const LendingRules kRules;

PeerLoad peer(const std::string& id, double load, double lent = 0) {
  PeerLoad one;
  one.id = id;
  one.load = load;
  one.lent = lent;
  one.age = 0.5;
  return one;
}

LendingInput asked(double load, std::vector<PeerLoad> peers) {
  LendingInput input;
  input.asked = load;
  input.peers = std::move(peers);
  return input;
}

std::vector<std::string> ids(const Lending& lending) {
  std::vector<std::string> all;
  for (const Helper& helper : lending.helpers) all.push_back(helper.id);
  return all;
}

Lending helped_by(const std::string& id) {
  Lending lending;
  lending.helpers.push_back({id, 0.5, 10});
  return lending;
}

TEST(Lending, BorrowsNothingWithoutOverload) {
  EXPECT_TRUE(lend({}, asked(1.0, {peer("a", 0)}), kRules, 1).helpers.empty());
  EXPECT_EQ(ids(lend({}, asked(1.4, {peer("a", 0)}), kRules, 1)), std::vector<std::string>{"a"});
}

TEST(Lending, BorrowsOnlyAsManyHelpersAsTheShortageNeeds) {
  const std::vector<PeerLoad> idle{peer("a", 0.5), peer("b", 0.5), peer("c", 0.5), peer("d", 0.5),
                                   peer("e", 0.5)};
  EXPECT_EQ(lend({}, asked(1.3, idle), kRules, 1).helpers.size(), 1u);
  EXPECT_EQ(lend({}, asked(1.9, idle), kRules, 1).helpers.size(), 2u);
  EXPECT_EQ(lend({}, asked(9, idle), kRules, 1).helpers.size(), kRules.most);
  LendingInput half = asked(2, idle);
  half.helped = 0.99;
  EXPECT_TRUE(lend({}, half, kRules, 1).helpers.empty()) << "what comes already";
}

TEST(Lending, SkipsBusyDrainingAndSilentPeers) {
  PeerLoad draining = peer("draining", 0), silent = peer("silent", 0);
  draining.draining = true;
  silent.age = kRules.oldest + 1;
  const auto made = lend({},
                         asked(4, {draining, silent, peer("full", 0.8),
                                   peer("helps others", 0.2, 0.6), peer("idle", 0.1)}),
                         kRules, 1);
  EXPECT_EQ(ids(made), std::vector<std::string>{"idle"});
}

TEST(Lending, ReturnsHelperThatIsBusyGoneOrDraining) {
  for (double load : {0.0, 0.5, 0.8}) {
    EXPECT_EQ(lend(helped_by("a"), asked(1.5, {peer("a", load, 0.2)}), kRules, 1).helpers.size(),
              1u)
        << load;
  }
  EXPECT_TRUE(lend(helped_by("a"), asked(1.5, {peer("a", 0.95)}), kRules, 1).helpers.empty());
  EXPECT_TRUE(lend(helped_by("a"), asked(1.5, {}), kRules, 1).helpers.empty()) << "it has gone";
  PeerLoad draining = peer("a", 0);
  draining.draining = true;
  EXPECT_TRUE(lend(helped_by("a"), asked(1.5, {draining}), kRules, 1).helpers.empty());
}

TEST(Lending, KeepsHelperThatIsBusyOnlyWithBorrowedWork) {
  EXPECT_EQ(lend(helped_by("a"), asked(1.5, {peer("a", 0.1, 0.9)}), kRules, 1).helpers.size(), 1u);
}

TEST(Lending, KeepsHelpersUntilOverloadHasEndedForAWhile) {
  const std::vector<PeerLoad> there{peer("a", 0, 0.3)};
  Lending lending = helped_by("a");
  for (int second = 0; second < 60; ++second) {
    // The demand alternates around the limit and is sometimes far below it.
    lending = lend(std::move(lending), asked(second % 3 == 0 ? 1.2 : 0.5, there), kRules, 1);
    ASSERT_EQ(lending.helpers.size(), 1u) << second;
  }
  lending = lend(std::move(lending), asked(1.2, there), kRules, 1);
  for (int second = 1; second <= 3; ++second) {
    ASSERT_EQ(lending.helpers.size(), 1u) << second;
    lending = lend(std::move(lending), asked(0.5, there), kRules, 1);
  }
  EXPECT_TRUE(lending.helpers.empty());
}

TEST(Lending, PrefersLoadedVolumeThenSameNode) {
  PeerLoad volume = peer("volume", 0.3), near = peer("near", 0.3);
  volume.has_volume = true;
  near.same_node = true;
  std::map<std::string, int> taken;
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    const auto made = lend({}, asked(1.3, {volume, near, peer("far", 0.3)}), kRules,
                           seed * 0x9e3779b97f4a7c15ULL);
    ++taken[made.helpers.at(0).id];
  }
  // The better of two random draws out of three: the best is chosen with probability 5/9, and the
  // last only if it is drawn twice. The bounds are five standard deviations of 3000 draws.
  EXPECT_NEAR(taken["volume"], 3000 * 5 / 9.0, 5 * std::sqrt(3000 * 5 / 9.0 * 4 / 9.0));
  EXPECT_NEAR(taken["near"], 3000 * 3 / 9.0, 5 * std::sqrt(3000 * 3 / 9.0 * 6 / 9.0));
  EXPECT_NEAR(taken["far"], 3000 * 1 / 9.0, 5 * std::sqrt(3000 * 1 / 9.0 * 8 / 9.0));
}

TEST(Lending, SpreadsConcurrentBorrowersOverNeighbours) {
  std::vector<PeerLoad> idle;
  for (int i = 0; i < 20; ++i) idle.push_back(peer(std::to_string(i), 0.01 * i));
  std::map<std::string, int> taken;
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
    ++taken[lend({}, asked(1.5, idle), kRules, seed * 0x9e3779b97f4a7c15ULL).helpers.at(0).id];
  }
  int most = 0;
  for (const auto& [id, times] : taken) most = std::max(most, times);
  // The best of 20 is the better of two random draws with probability 39/400, or 97 of 1000. The
  // bound is five standard deviations above.
  EXPECT_LT(most, 145);
}

LendingRules with_spare(std::size_t most) {
  LendingRules rules;
  rules.most = rules.most_spare = most;
  return rules;
}

std::size_t count_spare(const Lending& lending) {
  return static_cast<std::size_t>(std::count_if(lending.helpers.begin(), lending.helpers.end(),
                                                [](const Helper& one) { return one.spare; }));
}

TEST(Lending, HelpersAreAlwaysFewDistinctAndEligible) {
  std::mt19937 random(7);
  const auto unit = [&] { return std::uniform_real_distribution<double>()(random); };
  for (int world = 0; world < 600; ++world) {
    const LendingRules rules = world % 2 == 0 ? kRules : with_spare(5);
    Lending lending;
    for (int second = 0; second < 30; ++second) {
      LendingInput input = asked(3 * unit(), {});
      input.helped = unit();
      for (int i = 0; i < 12; ++i) {
        if (unit() < 0.2) continue;
        PeerLoad one = peer(std::to_string(i), unit(), unit());
        one.age = 5 * unit();
        one.draining = unit() < 0.1;
        one.has_volume = unit() < 0.5;
        one.same_node = unit() < 0.5;
        input.peers.push_back(one);
      }
      const Lending before = lending;
      lending = lend(std::move(lending), input, rules, random());
      const std::vector<std::string> after = ids(lending);
      std::map<std::string, bool> was_spare;
      for (const Helper& helper : before.helpers) was_spare[helper.id] = helper.spare;
      ASSERT_LE(after.size(), rules.most);
      ASSERT_EQ(std::set<std::string>(after.begin(), after.end()).size(), after.size());
      for (const Helper& helper : lending.helpers) {
        const std::string& id = helper.id;
        const auto known = std::find_if(input.peers.begin(), input.peers.end(),
                                        [&](const PeerLoad& one) { return one.id == id; });
        ASSERT_NE(known, input.peers.end());
        ASSERT_FALSE(known->draining);
        ASSERT_LE(known->age, rules.oldest);
        ASSERT_LT(known->load, helper.spare ? rules.spare_busy : rules.busy);
        const auto was = was_spare.find(id);
        if (helper.spare) {
          if (was != was_spare.end()) continue;
          ASSERT_LE(known->load + known->lent, rules.spare_idle);
          ASSERT_GE(input.asked, rules.renders);
        } else if (was == was_spare.end() || was->second) {
          ASSERT_LE(known->load + known->lent, rules.idle);
          ASSERT_GE(input.asked, rules.borrows);
        }
      }
    }
  }
}

TEST(Lending, AsksIdlePeersForSpareTimeWhileItsSessionsRender) {
  PeerLoad draining = peer("draining", 0);
  draining.draining = true;
  const std::vector<PeerLoad> peers{peer("a", 0), peer("b", 0.2), peer("busy", 0.4),
                                    peer("lends", 0.1, 0.6), draining};
  for (const double demand : {0.1, 0.9, 1.0}) {
    const Lending made = lend({}, asked(demand, peers), with_spare(7), 1);
    const auto all = ids(made);
    EXPECT_EQ(std::set(all.begin(), all.end()), (std::set<std::string>{"a", "b"})) << demand;
    EXPECT_EQ(count_spare(made), 2u) << demand;
    EXPECT_EQ(lend({}, asked(demand, peers), with_spare(1), 1).helpers.size(), 1u) << demand;
  }
  EXPECT_TRUE(lend({}, asked(0.01, peers), with_spare(7), 1).helpers.empty());
}

TEST(Lending, KeepsSpareTimeForAWhileBetweenPictures) {
  const LendingRules rules = with_spare(7);
  const std::vector<PeerLoad> peers{peer("a", 0)};
  Lending lending;
  for (int second = 0; second < 100; ++second) {
    lending = lend(std::move(lending), asked(second % 25 == 0 ? 0.5 : 0, peers), rules, 1);
    ASSERT_EQ(lending.helpers.size(), 1u) << second;
  }
  for (int second = 0; second < 30; ++second) {
    lending = lend(std::move(lending), asked(0, peers), rules, 1);
  }
  EXPECT_TRUE(lending.helpers.empty());
}

TEST(Lending, ReturnsSpareTimeOfAPeerWithSessionsOfItsOwn) {
  const LendingRules rules = with_spare(7);
  const Lending lending = lend({}, asked(1, {peer("a", 0)}), rules, 1);
  EXPECT_EQ(lend(lending, asked(1, {peer("a", 0.4)}), rules, 1).helpers.size(), 1u);
  EXPECT_TRUE(lend(lending, asked(1, {peer("a", 0.6)}), rules, 1).helpers.empty());
  // It may help others who need it.
  EXPECT_EQ(lend(lending, asked(1, {peer("a", 0, 1)}), rules, 1).helpers.size(), 1u);
}

TEST(Lending, PromotesSpareTimeDuringOverloadAndDemotesItAfterwards) {
  const LendingRules rules = with_spare(3);
  const std::vector<PeerLoad> peers{peer("a", 0), peer("b", 0), peer("c", 0)};
  Lending lending = lend({}, asked(1, peers), rules, 1);
  ASSERT_EQ(count_spare(lending), 3u);
  lending = lend(std::move(lending), asked(1.9, peers), rules, 1);
  EXPECT_EQ(lending.helpers.size(), 3u);
  EXPECT_EQ(count_spare(lending), 2u) << "one idle device is enough";
  const std::vector<PeerLoad> helps{peer("a", 0, 0.6), peer("b", 0), peer("c", 0)};
  for (int second = 1; second <= 3; ++second) {
    ASSERT_EQ(count_spare(lending), 2u) << second;
    lending = lend(std::move(lending), asked(1, helps), rules, 1);
  }
  EXPECT_EQ(count_spare(lending), 3u) << "the device is sufficient again";
  // A peer that has begun to help others with all it has is not promoted.
  const std::vector<PeerLoad> taken{peer("a", 0, 1), peer("b", 0, 1), peer("c", 0, 1)};
  EXPECT_EQ(count_spare(lend(lending, asked(3, taken), rules, 1)), 3u);
}

TEST(Lending, BorrowsNothingWhenDisabled) {
  LendingRules none;
  none.most = 0;
  EXPECT_TRUE(lend({}, asked(5, {peer("a", 0)}), none, 1).helpers.empty());
  EXPECT_TRUE(lend(helped_by("a"), asked(5, {peer("a", 0)}), none, 1).helpers.empty());
}

}  // namespace
}  // namespace diaphane::directory
