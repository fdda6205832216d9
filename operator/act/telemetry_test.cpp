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

Reply answer(const std::vector<Reply>& workers) {
  Reply reply = list({"5000000", "", "", ""});
  reply.list[1] = list({"2"});
  reply.list[2] = list({"4990000"});
  reply.list[3].kind = Reply::Kind::kList;
  reply.list[3].list = workers;
  return reply;
}

TEST(TelemetryOfRedis, TakesAgesNotTimesFromItsClock) {
  const Reading reading = read_telemetry(
      answer({list({"skull/w/3", "500", "0.25", "0.5", "3", "5", "16", "1.5", "1", "4940000"})}),
      {"skull"}, 100);
  ASSERT_EQ(reading.telemetry.size(), 1U);
  const Telemetry& sample = reading.telemetry[0];
  EXPECT_EQ(sample.worker_uid, "w");
  EXPECT_EQ(sample.epoch, 3);
  EXPECT_EQ(sample.sampled, 99.5);
  EXPECT_EQ(sample.busy, 0.25);
  EXPECT_EQ(sample.sessions, 3);
  EXPECT_EQ(sample.reserved, 2);
  EXPECT_EQ(sample.error, 1.5);
  EXPECT_TRUE(sample.draining);
  EXPECT_EQ(sample.idle_since, 40);
  ASSERT_EQ(reading.demand.size(), 1U);
  EXPECT_EQ(reading.demand[0].used, 3);
  EXPECT_EQ(reading.demand[0].reserved, 2);
  EXPECT_EQ(reading.demand[0].refused, 2);
  EXPECT_EQ(reading.demand[0].last_used, 90);
}

TEST(TelemetryOfRedis, WhoIsOfNoFleetIsLeftOut) {
  for (const char* owner : {"", "x", "x/y", "/"}) {
    const Reading reading = read_telemetry(
        answer({list({owner, "0", "0", "0", "0", "0", "1", "0", "0", "0"})}), {"skull"}, 100);
    EXPECT_TRUE(reading.telemetry.empty()) << owner;
  }
}

TEST(TelemetryBook, KeepsTheLastSampleOfWhoHasGoneSilent) {
  TelemetryBook book;
  World world;
  world.workers.emplace_back().uid = "w";
  book.note(
      read_telemetry(answer({list({"skull/w/3", "0", "0", "0", "1", "1", "16", "0", "0", "0"})}),
                     {"skull"}, 100),
      100);
  book.note(read_telemetry(answer({}), {"skull"}, 102), 102);
  world.now = 120;
  book.fill(world);
  ASSERT_EQ(world.telemetry.size(), 1U);
  EXPECT_EQ(world.telemetry[0].sampled, 100);
  EXPECT_EQ(world.listening_since, 100);
  EXPECT_EQ(world.listened_until, 102);
  EXPECT_EQ(world.demand[0].sampled, 102);
  World without;
  book.fill(without);
  EXPECT_TRUE(without.telemetry.empty());
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
