#include "operator/kube/watch.h"

#include <gtest/gtest.h>

#include "operator/kube/store.h"

namespace diaphane::kube {
namespace {

using nlohmann::json;
using Type = WatchEvent::Type;

TEST(Watch, ParsesEventsSplitAtAnyByte) {
  const std::string text = R"({"type":"ADDED","object":{"metadata":{"name":"a"}}})"
                           "\n"
                           R"({"type":"MODIFIED","object":{"metadata":{"name":"b"}}})"
                           "\n\n"
                           R"({"type":"DELETED","object":{}})"
                           "\n"
                           R"({"type":"BOOKMARK","object":{"metadata":{"resourceVersion":"9"}}})"
                           "\n";
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    WatchReader reader;
    std::vector<WatchEvent> events = reader.feed(std::string_view(text).substr(0, cut));
    for (WatchEvent& one : reader.feed(std::string_view(text).substr(cut))) {
      events.push_back(std::move(one));
    }
    ASSERT_EQ(events.size(), 4U);
    EXPECT_EQ(events[0].type, Type::kAdded);
    EXPECT_EQ(events[1].object["metadata"]["name"], "b");
    EXPECT_EQ(events[2].type, Type::kDeleted);
    EXPECT_EQ(events[3].type, Type::kBookmark);
  }
}

TEST(Watch, ReportsMalformedEventAsError) {
  for (const char* line :
       {"", "x", "[]", "{}", R"({"type":"ADDED"})", R"({"type":"NEWS","object":{}})",
        R"({"type":7,"object":{"code":"410"}})"}) {
    EXPECT_EQ(read_event(line).type, Type::kError) << line;
  }
}

TEST(Watch, RelistsOnTooOldOrTooNewVersion) {
  EXPECT_EQ(read_event(R"({"type":"ERROR","object":{"code":410,"reason":"Expired"}})").type,
            Type::kExpired);
  EXPECT_EQ(read_event(R"({"type":"ERROR","object":{"code":500}})").type, Type::kError);
  EXPECT_TRUE(must_list_again(410, json()));
  EXPECT_TRUE(
      must_list_again(504, {{"message", "Timeout: Too large resource version: 9, current: 3"}}));
  EXPECT_TRUE(
      must_list_again(504, {{"details", {{"causes", {{{"reason", "ResourceVersionTooLarge"}}}}}}}));
  EXPECT_FALSE(must_list_again(504, {{"message", "Timeout"}}));
  EXPECT_FALSE(must_list_again(500, "words"));
}

TEST(Watch, ComparesVersionsOfAnyLength) {
  EXPECT_LT(compare_versions("9", "10"), 0);
  EXPECT_GT(compare_versions("340282366920938463463374607431768211456", "18446744073709551616"), 0);
  EXPECT_EQ(compare_versions("007", "7"), 0);
  EXPECT_LT(compare_versions("", "1"), 0);
}

struct Thing {
  std::string name, uid, version;
};
bool equal_except_version(const Thing& a, const Thing& b) {
  return a.name == b.name && a.uid == b.uid;
}

TEST(Store, ShowsOwnWriteBeforeItsWatchEvent) {
  Store<Thing> store;
  store.replace({{"a", "1", "5"}}, "5");
  store.apply_own_write({"b", "2", "7"});
  ASSERT_TRUE(store.find("b"));
  store.changed({"b", "2", "7"});
  EXPECT_EQ(store.version(), "7");
}

TEST(Store, LateWriteResponseDoesNotRestoreDeletedObject) {
  Store<Thing> store;
  store.replace({}, "5");
  store.changed({"b", "2", "7"});
  store.deleted("b", "8");
  store.apply_own_write({"b", "2", "7"});
  EXPECT_FALSE(store.find("b"));
}

TEST(Store, OlderEventDoesNotRevertOwnWrite) {
  Store<Thing> store;
  store.replace({{"a", "1", "5"}}, "5");
  store.apply_own_write({"a", "1", "9"});
  store.changed({"a", "1", "7"});
  EXPECT_EQ(store.find("a")->version, "9");
}

TEST(Store, RelistRemovesMissingObjects) {
  Store<Thing> store;
  EXPECT_FALSE(store.listed());
  store.replace({{"a", "1", "5"}, {"b", "2", "5"}}, "5");
  store.replace({{"b", "2", "5"}}, "20");
  EXPECT_TRUE(store.listed());
  store.visit([](const auto& all) { EXPECT_EQ(all.size(), 1U); });
  EXPECT_EQ(store.version(), "20");
}

}  // namespace
}  // namespace diaphane::kube
