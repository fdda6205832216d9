#include "operator/act/retire.h"

#include <gtest/gtest.h>

#include "tests/support/operator/fake_transport.h"

namespace diaphane::fleet {
namespace {

using What = RetireStep::What;

Json object(const char* name, bool deleted, bool held) {
  Json made = {{"metadata", {{"name", name}, {"uid", std::string(name) + "-uid"}}},
               {"spec", {{"fleetName", "skull"}}}};
  if (deleted) made["metadata"]["deletionTimestamp"] = "2026-11-22T10:00:00Z";
  made["metadata"]["finalizers"] = Json::array({"other/one"});
  if (held) made["metadata"]["finalizers"].push_back("diaphane.dev/drain");
  return made;
}

std::vector<std::string> words(const std::vector<RetireStep>& steps) {
  std::vector<std::string> all;
  for (const RetireStep& step : steps) {
    all.push_back((step.what == What::kDelete ? "delete " : "let go ") +
                  step.object["metadata"]["name"].get<std::string>());
  }
  return all;
}

using Words = std::vector<std::string>;

TEST(Retire, DeletesFleetAndWaitsForItsOperatorWithinTheGracePeriod) {
  EXPECT_EQ(words(retire_steps({object("skull", false, true), {}}, true)), Words{"delete skull"});
  EXPECT_EQ(words(retire_steps({object("skull", true, true), {}}, true)), Words{});
  EXPECT_EQ(words(retire_steps({std::nullopt, {object("a", false, true)}}, true)), Words{});
}

TEST(Retire, RemovesFinalizersOfWorkersAndThenOfTheFleetAfterTheGracePeriod) {
  const Remains left{object("skull", true, true),
                     {object("a", false, true), object("b", true, true), object("c", true, false)}};
  EXPECT_EQ(words(retire_steps(left, false)), (Words{"delete a", "let go b"}));
  EXPECT_EQ(words(retire_steps({object("skull", true, true), {}}, false)), Words{"let go skull"});
  EXPECT_EQ(words(retire_steps({object("skull", false, true), {}}, false)), Words{"delete skull"});
  // Foreign finalizers are kept.
  EXPECT_EQ(words(retire_steps({object("skull", true, false), {}}, false)), Words{});
}

struct Shell {
  kube::FakeTransport wire;
  kube::Api api{wire, "retire"};
  Seconds now = 0;
  RetireOptions options{"here", "skull", 2, [this] { return now; }, [this] { now += 1; }};

  void put(int status, const Json& body) { wire.put({status, body.dump()}); }
  Words asked() const {
    Words all;
    for (const kube::Request& one : wire.asked()) {
      all.push_back(one.method + " " + one.path.substr(one.path.rfind('/') + 1));
    }
    return all;
  }
};

TEST(Retire, DoesNotInterfereWithTimelyDrain) {
  Shell shell;
  shell.put(200, object("skull", false, true));
  shell.put(200, Json::object());
  shell.put(200, object("skull", true, true));
  shell.put(404, Json::object());
  shell.put(200, {{"items", Json::array()}});
  ASSERT_TRUE(retire(shell.api, shell.options));
  EXPECT_EQ(shell.asked(),
            (Words{"GET skull", "DELETE skull", "GET skull", "GET skull", "GET renderworkers"}));
}

TEST(Retire, RemovesOnlyOwnFinalizersOfThatFleetAfterTheGracePeriod) {
  Shell shell;
  shell.now = 0;
  shell.options.grace = 0;
  Json foreign = object("z", true, true);
  foreign["spec"]["fleetName"] = "other";
  shell.put(200, object("skull", true, true));
  shell.put(200, {{"items", {foreign, object("a", true, true)}}});
  shell.put(409, {{"reason", "Conflict"}});
  shell.put(500, Json::object());
  shell.put(200, object("skull", true, true));
  shell.put(200, {{"items", {foreign, object("a", true, true)}}});
  shell.put(200, Json::object());
  shell.put(200, object("skull", true, true));
  shell.put(200, {{"items", {foreign}}});
  shell.put(200, Json::object());
  shell.put(404, Json::object());
  shell.put(200, {{"items", {foreign}}});
  ASSERT_TRUE(retire(shell.api, shell.options));
  EXPECT_EQ(shell.asked(),
            (Words{"GET skull", "GET renderworkers", "PUT a", "GET skull", "GET skull",
                   "GET renderworkers", "PUT a", "GET skull", "GET renderworkers", "PUT skull",
                   "GET skull", "GET renderworkers"}));
  const Json sent = Json::parse(shell.wire.asked()[2].body);
  EXPECT_EQ(sent["metadata"]["finalizers"], Json::array({"other/one"}));
}

TEST(Retire, StopsWhenForbidden) {
  Shell shell;
  shell.put(200, object("skull", false, true));
  shell.put(403, {{"reason", "Forbidden"}, {"message", "cannot delete resource"}});
  const auto done = retire(shell.api, shell.options);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::kForbidden);
}

}  // namespace
}  // namespace diaphane::fleet
