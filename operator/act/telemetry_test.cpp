#include "operator/observe/telemetry.h"

#include <gtest/gtest.h>

namespace diaphane::fleet {
namespace {

using api::redis::Reply;

Reply list(const std::vector<std::string>& words) {
  Reply reply;
  reply.kind = Reply::Kind::kList;
  for (const std::string& word : words) {
    reply.list.emplace_back();
    reply.list.back().kind = Reply::Kind::kText;
    reply.list.back().text = word;
  }
  return reply;
}

Reply page(const std::string& workers, const std::string& next = "0") {
  Reply reply = list({next, "5000000", "", "", workers});
  reply.list[2] = list({"2"});
  reply.list[3] = list({"4990000"});
  return reply;
}

Reading read(const std::vector<Reply>& pages, Seconds now = 100) {
  TelemetryReader reader({"skull"});
  for (const Reply& one : pages) EXPECT_TRUE(reader.add(one, now));
  return reader.take();
}

TEST(TelemetryOfRedis, TakesAgesNotTimesFromItsClock) {
  const Reading reading = read({page("skull/w/3 500 0.25 0.5 3 5 16 1.5 1 4940000")});
  ASSERT_EQ(reading.telemetry.size(), 1U);
  const Telemetry& sample = reading.telemetry[0];
  EXPECT_EQ(sample.worker_uid, "w");
  EXPECT_EQ(sample.epoch, 3);
  EXPECT_EQ(sample.sampled, 99.5);
  EXPECT_EQ(sample.busy, 0.25);
  EXPECT_EQ(sample.memory, 0.5);
  EXPECT_EQ(sample.sessions, 3);
  EXPECT_EQ(sample.reserved, 2);
  EXPECT_EQ(sample.slots, 16);
  EXPECT_EQ(sample.error, 1.5);
  EXPECT_TRUE(sample.draining);
  EXPECT_EQ(sample.idle_since, 40);
  ASSERT_EQ(reading.demand.size(), 1U);
  EXPECT_EQ(reading.demand[0].used, 3);
  EXPECT_EQ(reading.demand[0].reserved, 2);
  EXPECT_EQ(reading.demand[0].refused, 2);
  EXPECT_EQ(reading.demand[0].last_used, 90);
}

TEST(TelemetryOfRedis, AllPagesAreOneReadingAndWhoComesTwiceCountsOnce) {
  const std::string of_v = "skull/v/1 0 0 0 1 1 16 0 0 0";
  const std::string of_w = "skull/w/3 0 0 0 2 2 16 0 0 0";
  const std::string before = "skull/w/2 0 0 0 4 4 16 0 0 0";
  TelemetryReader reader({"skull"});
  EXPECT_EQ(reader.add(page(of_v + "\n" + of_w, "17"), 100), "17");
  EXPECT_EQ(reader.add(page("", "5"), 100), "5");
  EXPECT_EQ(reader.add(page(of_w + "\n" + before), 101), kFirstPage);
  const Reading reading = reader.take();
  EXPECT_EQ(reading.telemetry.size(), 3U);
  EXPECT_EQ(reading.demand[0].used, 1 + 2 + 4);
  EXPECT_EQ(reading.demand[0].refused, 2) << "each page says all";
  EXPECT_EQ(reading.demand[0].sampled, 101);
}

TEST(TelemetryOfRedis, WhoIsOfNoFleetOrSaysNonsenseIsLeftOut) {
  const std::string good = "skull/w/3 0 0 0 1 1 16 0 0 0";
  for (const char* line : {"", " 0 0 0 0 0 1 0 0 0", "x 0 0 0 0 0 1 0 0 0", "x/y 0 0 0 0 0 1 0 0 0",
                           "/ 0 0 0 0 0 1 0 0 0", "skull/v/1 0 0 0 0 0 1 0 0",
                           "skull/v/1 0 0 0 0 0 1 0 0 0 0", "skull/v/1", "          "}) {
    const Reading reading = read({page(std::string(line) + "\n" + good)});
    ASSERT_EQ(reading.telemetry.size(), 1U) << line;
    EXPECT_EQ(reading.telemetry[0].worker_uid, "w");
  }
  const Reading odd = read({page("skull/w/x nan x 1e999 -5 1e300 -1 nan 2 x")});
  ASSERT_EQ(odd.telemetry.size(), 1U);
  EXPECT_EQ(odd.telemetry[0].sessions, 0);
  EXPECT_EQ(odd.telemetry[0].slots, 0);
}

TEST(TelemetryOfRedis, WhatIsNoAnswerIsSaid) {
  TelemetryReader reader({"skull"});
  EXPECT_FALSE(reader.add(Reply(), 100));
  EXPECT_FALSE(reader.add(list({"", "1", "", "", ""}), 100));
}

TEST(TelemetryBook, KeepsTheLastSampleOfWhoHasGoneSilent) {
  TelemetryBook book;
  World world;
  world.workers.emplace_back().uid = "w";
  book.note(read({page("skull/w/3 0 0 0 1 1 16 0 0 0")}), 100);
  book.note(read({page("")}, 102), 102);
  world.now = 120;
  for (int again = 0; again < 2; ++again) {
    book.fill(world);
    ASSERT_EQ(world.telemetry.size(), 1U);
    EXPECT_EQ(world.telemetry[0].sampled, 100);
    EXPECT_EQ(world.listening_since, 100);
    EXPECT_EQ(world.listened_until, 102);
    EXPECT_EQ(world.demand[0].sampled, 102);
  }
  world.workers.clear();
  book.fill(world);
  EXPECT_TRUE(world.telemetry.empty());
}

TEST(TelemetryBook, ListensAnewAfterAGap) {
  TelemetryBook book;
  const auto since = [&] {
    World world;
    book.fill(world);
    return world.listening_since;
  };
  for (const Seconds now : {100, 101, 103}) book.note({}, now);
  EXPECT_EQ(since(), 100);
  book.missed();
  EXPECT_EQ(since(), 100);
  book.note({}, 104);
  EXPECT_EQ(since(), 104);
  book.note({}, 108);  // it stood still itself
  EXPECT_EQ(since(), 108);
}

}  // namespace
}  // namespace diaphane::fleet
