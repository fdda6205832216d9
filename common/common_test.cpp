#include <gtest/gtest.h>

#include <set>

#include "common/config.h"
#include "common/ids.h"
#include "common/log.h"

namespace diaphane {
namespace {

TEST(Ids, EveryIdIsWellFormedAndDifferent) {
  std::set<std::string> seen;
  for (int i = 0; i < 1000; ++i) {
    const std::string id = new_id();
    EXPECT_TRUE(is_id(id)) << id;
    EXPECT_TRUE(seen.insert(id).second);
  }
}

TEST(Ids, WhatCouldLeaveADirectoryIsNoId) {
  EXPECT_FALSE(is_id(""));
  EXPECT_FALSE(is_id("../../../../../../../../../etc/passwd!"));
  EXPECT_FALSE(is_id("00000000-0000-0000-0000-00000000000G"));
  EXPECT_FALSE(is_id("00000000-0000-0000-0000-0000000000000"));
  EXPECT_FALSE(is_id("00000000-0000-0000-0000-00000000000A"));
}

TEST(Config, AnOptionWinsOverTheEnvironment) {
  ConfigReader in({"--api-port", "81"}, {{"DIAPHANE_API_PORT", "80"}, {"DIAPHANE_REDIS", "r:1"}});
  EXPECT_EQ(in.port("api-port", "REST"), 81);
  EXPECT_EQ(in.text("redis", "host:port"), "r:1");
  EXPECT_FALSE(in.finish("test").has_value());
}

TEST(Config, AllMistakesAreReportedTogether) {
  ConfigReader in({"--api-port=99999", "--engine", "abacus"}, {});
  in.port("api-port", "REST");
  in.text("redis", "host:port");
  in.one_of("engine", "which", {"auto", "cpu", "cuda"}, "auto");
  EXPECT_EQ(in.finish("test"), kExitConfig);
  EXPECT_EQ(in.mistakes().size(), 3u);
}

TEST(Config, AnUnknownOptionIsAUsageError) {
  ConfigReader in({"--nonsense", "1"}, {});
  EXPECT_EQ(in.finish("test"), kExitUsage);
}

}  // namespace
}  // namespace diaphane
