#include "renderd/session/saving.h"

#include <gtest/gtest.h>

#include "tests/support/renderd/test_messages.h"

namespace diaphane::render {
namespace {

TEST(SavingTest, ReturnsEachChangeOnce) {
  SessionState state;
  state.id = "session";
  state.unsaved = true;
  EXPECT_FALSE(take_unsaved(state));  // there is no scene yet
  state.requested.scene = std::make_shared<const v1::Scene>(plain_scene());
  state.requested.input_seq = 7;
  const auto saved = take_unsaved(state);
  ASSERT_TRUE(saved);
  EXPECT_EQ(saved->id, "session");
  EXPECT_EQ(saved->input_seq, 7u);
  EXPECT_EQ(saved->scene, plain_scene().SerializeAsString());
  EXPECT_FALSE(take_unsaved(state));
}

TEST(SavingTest, RecordNamesEachLinkOnceAndLeavesSceneUnsaved) {
  SessionState state;
  state.unsaved = true;
  EXPECT_FALSE(recovery_record(state, "user", true));
  state.requested.scene = std::make_shared<const v1::Scene>(plain_scene());
  attach(state, owner(), {});
  for (const char* guest : {"a", "b"}) {
    JoinRequest join;
    join.participant = guest;
    join.link = "link";
    attach(state, join, {});
  }
  JoinRequest join;
  join.participant = "c";
  join.link = "wide";
  join.may_have_slices = true;
  attach(state, join, {});
  const auto record = recovery_record(state, "user", true);
  ASSERT_TRUE(record);
  EXPECT_EQ(record->user_id, "user");
  EXPECT_EQ(record->links, (std::vector<std::string>{"link", "wide slices"}));
  EXPECT_TRUE(record->visitor);
  EXPECT_TRUE(take_unsaved(state));
}

}  // namespace
}  // namespace diaphane::render
