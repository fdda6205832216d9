#include "operator/kube/informer.h"

#include <gtest/gtest.h>

#include "tests/support/operator/fake_transport.h"

namespace diaphane::kube {
namespace {

using nlohmann::json;

struct Thing {
  std::string name, uid, version;
};
bool equal_except_version(const Thing& a, const Thing& b) {
  return a.name == b.name && a.uid == b.uid;
}

json thing(const std::string& name, const std::string& version) {
  return {{"metadata", {{"name", name}, {"uid", "u-" + name}, {"resourceVersion", version}}}};
}
std::string list_of(const std::vector<json>& items, const std::string& version,
                    const std::string& next = "") {
  return json{{"metadata", {{"resourceVersion", version}, {"continue", next}}}, {"items", items}}
      .dump();
}
std::string event(const char* type, const json& object) {
  return json{{"type", type}, {"object", object}}.dump() + "\n";
}

class InformerTest : public testing::Test {
 protected:
  void start() {
    Reflector::Options options;
    options.path = "/things";
    options.kind = "things";
    options.backoff.first = std::chrono::milliseconds(1);
    options.backoff.longest = std::chrono::milliseconds(4);
    options.silence = silence_;
    informer_ = std::make_unique<Informer<Thing>>(
        options, transport_,
        [](const json& object) {
          const json& m = object["metadata"];
          return std::optional<Thing>({m["name"], m["uid"], m["resourceVersion"]});
        },
        [this] {
          const std::lock_guard lock(mutex_);
          ++notified_;
          changed_.notify_all();
        });
  }
  void TearDown() override {
    transport_.stop();
    informer_.reset();
  }
  template <typename Condition>
  bool wait_until(const Condition& condition) {
    std::unique_lock lock(mutex_);
    for (int i = 0; i < 2000; ++i) {
      if (condition()) return true;
      changed_.wait_for(lock, std::chrono::milliseconds(5));
    }
    return false;
  }
  std::string names() const {
    std::string names;
    informer_->store().visit([&](const auto& all) {
      for (const auto& [name, one] : all) names += one.name + one.version + " ";
    });
    return names;
  }

  FakeTransport transport_;
  std::chrono::milliseconds silence_{75'000};
  std::mutex mutex_;
  std::condition_variable changed_;
  int notified_ = 0;  // number of change notifications
  std::unique_ptr<Informer<Thing>> informer_;
};

TEST_F(InformerTest, ListsInPagesAndWatchesFromTheListedVersion) {
  transport_.put({200, list_of({thing("a", "3")}, "5", "to/ken=")});
  transport_.put({200, list_of({thing("b", "4")}, "5")});
  transport_.put({200,
                  event("MODIFIED", thing("a", "6")) + event("ADDED", thing("c", "7")) +
                      event("DELETED", thing("b", "8")),
                  true});
  start();
  ASSERT_TRUE(wait_until([&] { return names() == "a6 c7 "; })) << names();
  const auto asked = transport_.asked();
  EXPECT_NE(asked[1].query.find("continue=to%2Fken%3D"), std::string::npos);
  EXPECT_NE(asked[2].query.find("resourceVersion=5"), std::string::npos);
  EXPECT_NE(asked[2].query.find("allowWatchBookmarks=true"), std::string::npos);
}

TEST_F(InformerTest, NotifiesOfOwnWriteOnceAndIgnoresItsEcho) {
  transport_.put({200, list_of({thing("a", "3")}, "5")});
  start();
  ASSERT_TRUE(wait_until([&] { return notified_ == 1; }));
  informer_->apply_own_write(thing("b", "6"));
  EXPECT_EQ(notified_, 2);
  transport_.put({200,
                  event("ADDED", thing("b", "6")) + event("MODIFIED", thing("a", "7")) +
                      event("DELETED", thing("b", "8")),
                  true});
  ASSERT_TRUE(wait_until([&] { return names() == "a7 "; })) << names();
  ASSERT_TRUE(wait_until([&] { return notified_ == 3; }));
  EXPECT_EQ(notified_, 3) << "b came and went; of a but the version is another";
}

TEST_F(InformerTest, ResumesBrokenWatchFromItsLastBookmark) {
  transport_.put({200, list_of({thing("a", "3")}, "5")});
  transport_.put({200, event("BOOKMARK", {{"metadata", {{"resourceVersion", "90"}}}})});
  transport_.put({0, ""});
  transport_.put({200, event("ADDED", thing("b", "91")), true});
  start();
  ASSERT_TRUE(wait_until([&] { return names() == "a3 b91 "; })) << names();
  EXPECT_NE(transport_.asked()[3].query.find("resourceVersion=90"), std::string::npos);
  EXPECT_EQ(informer_->reflector().counts().lists, 1U);
}

TEST_F(InformerTest, RelistsWhenAVersionExpiredInAResponseOrAWatch) {
  const json gone = {{"code", 410}, {"reason", "Expired"}};
  transport_.put({200, list_of({thing("a", "3"), thing("b", "4")}, "5")});
  transport_.put({200, event("ERROR", gone)});
  transport_.put({200, list_of({thing("b", "4")}, "50")});
  transport_.put({410, gone.dump()});
  transport_.put({200, list_of({thing("c", "60")}, "70")});
  transport_.put({504, R"({"message":"Timeout: Too large resource version: 70, current: 60"})"});
  transport_.put({200, list_of({thing("d", "61")}, "61")});
  transport_.put({200, "", true});
  start();
  ASSERT_TRUE(wait_until([&] { return names() == "d61 "; })) << names();
  EXPECT_EQ(informer_->reflector().counts().expired, 3U);
}

TEST_F(InformerTest, ListThatExpiresBetweenPagesKeepsKnownObjects) {
  transport_.put({200, list_of({thing("a", "3")}, "5")});
  transport_.put({200, event("ERROR", {{"code", 410}})});
  transport_.put({200, list_of({thing("b", "4")}, "9", "next")});
  transport_.put({410, "{}"});
  transport_.put({0, ""});
  start();
  ASSERT_TRUE(wait_until([&] { return transport_.asked().size() >= 6; }));
  EXPECT_EQ(names(), "a3 ");
}

TEST_F(InformerTest, RestartsSilentWatchFromItsLastVersion) {
  silence_ = std::chrono::milliseconds(50);
  transport_.put({200, list_of({thing("a", "3")}, "5")});
  transport_.put({200, event("BOOKMARK", {{"metadata", {{"resourceVersion", "90"}}}}), true});
  transport_.put({200, event("ADDED", thing("b", "91"))});
  start();
  ASSERT_TRUE(wait_until([&] { return names() == "a3 b91 "; })) << names();
  EXPECT_NE(transport_.asked()[2].query.find("resourceVersion=90"), std::string::npos);
  EXPECT_EQ(informer_->reflector().counts().silent, 1U);
  EXPECT_EQ(informer_->reflector().counts().failures, 0U);
}

TEST_F(InformerTest, UnansweredWatchCountsAsFailure) {
  silence_ = std::chrono::milliseconds(50);
  transport_.put({200, list_of({thing("a", "3")}, "5")});
  transport_.put({0, "", true});
  transport_.put({200, event("ADDED", thing("b", "91"))});
  start();
  ASSERT_TRUE(wait_until([&] { return names() == "a3 b91 "; })) << names();
  EXPECT_EQ(informer_->reflector().counts().silent, 0U);
  EXPECT_EQ(informer_->reflector().counts().failures, 1U);
}

TEST_F(InformerTest, RetriesUnavailableServerIndefinitely) {
  for (int i = 0; i < 40; ++i) transport_.put({i % 2 == 0 ? 0 : 503, "no"});
  transport_.put({200, list_of({thing("a", "3")}, "5")});
  start();
  ASSERT_TRUE(wait_until([&] { return names() == "a3 "; }));
}

}  // namespace
}  // namespace diaphane::kube
