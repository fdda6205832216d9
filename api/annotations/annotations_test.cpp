#include "api/annotations/annotations.h"

#include "tests/support/api/data_set_fixture.h"
#include "tests/support/api/fake_annotation_store.h"

namespace diaphane::api {
namespace {

class AnnotationSetsTest : public DataSetFixture {
 protected:
  static AnnotationSet named(const std::string& name, bool is_shared = false) {
    AnnotationSet set;
    set.name = name;
    set.content = "{}";
    set.shared = is_shared;
    return set;
  }
  /// Adds a set of this user and returns its ID.
  std::string added(const Principal& who, bool is_shared = false) {
    const auto made = sets.add(who, id, named("Of " + who.user_id, is_shared));
    EXPECT_TRUE(made);
    return made ? made->id : "";
  }
  std::size_t seen_by(const Principal& who) {
    const auto found = sets.list(who, id);
    return found ? found->size() : 0;
  }

  const Principal editor = as(Role::kSharedEdit);
  FakeAnnotationStore store;
  AnnotationSets sets{data_sets, store, clock};
};

TEST_F(AnnotationSetsTest, ListingAndSavingNeedTheirPermissions) {
  expect_permission(Action::kLook,
                    [&](const Principal& who) { return refusal(sets.list(who, id)); });
  expect_permission(Action::kSavePreset, [&](const Principal& who) {
    return refusal(sets.add(who, id, named("Mine")));
  });
}

TEST_F(AnnotationSetsTest, OnlyTheAuthorSeesASetThatIsNotShared) {
  added(owner);
  added(editor);
  EXPECT_EQ(seen_by(owner), 1u);
  EXPECT_EQ(seen_by(editor), 1u);
  EXPECT_EQ(seen_by(shared), 0u);
  added(owner, true);
  EXPECT_EQ(seen_by(shared), 1u);
  EXPECT_EQ(seen_by(editor), 2u);
}

TEST_F(AnnotationSetsTest, OnlyTheOwnerOfTheScanCanShareTheirs) {
  EXPECT_EQ(refusal(sets.add(editor, id, named("Loud", true))), ProblemKind::kForbidden);
  const std::string mine = added(editor);
  AnnotationChange share;
  share.shared = true;
  EXPECT_EQ(refusal(sets.change(editor, id, mine, share)), ProblemKind::kForbidden);
  EXPECT_FALSE(store.sets.front().shared);
  const auto changed = sets.change(owner, id, added(owner), share);
  ASSERT_TRUE(changed);
  EXPECT_TRUE(changed->shared);
}

TEST_F(AnnotationSetsTest, OnlyItsAuthorChangesOrDeletesASet) {
  const std::string hidden = added(owner), seen = added(owner, true);
  for (const auto& [set, expected] :
       {std::pair(hidden, ProblemKind::kNotFound), std::pair(seen, ProblemKind::kForbidden)}) {
    EXPECT_EQ(refusal(sets.change(editor, id, set, {})), expected);
    EXPECT_EQ(refusal(sets.remove(editor, id, set)), expected);
  }
  AnnotationChange change;
  change.name = "Before surgery";
  change.shown = false;
  const auto changed = sets.change(owner, id, hidden, change);
  ASSERT_TRUE(changed);
  EXPECT_EQ(changed->name, "Before surgery");
  EXPECT_FALSE(changed->shown);
  EXPECT_TRUE(sets.remove(owner, id, hidden));
  EXPECT_EQ(refusal(sets.remove(owner, id, hidden)), ProblemKind::kNotFound);
}

TEST_F(AnnotationSetsTest, RefusesAChangeOfOlderContent) {
  const std::string set = added(owner);
  AnnotationChange first;
  first.content = "{\"a\":1}";
  first.revision = revision_of(store.sets.front());
  AnnotationChange late = first;
  late.content = "{\"b\":1}";
  ASSERT_TRUE(sets.change(owner, id, set, first));
  EXPECT_EQ(refusal(sets.change(owner, id, set, late)), ProblemKind::kPrecondition);
  EXPECT_EQ(store.sets.front().content, *first.content);
  late.revision = revision_of(store.sets.front());
  EXPECT_TRUE(sets.change(owner, id, set, late));
  AnnotationChange name;
  name.name = "Any revision";
  EXPECT_TRUE(sets.change(owner, id, set, name));
}

TEST_F(AnnotationSetsTest, ASetBelongsToItsScan) {
  const std::string set = added(owner);
  EXPECT_EQ(refusal(sets.remove(owner, add_scan(), set)), ProblemKind::kNotFound);
}

TEST_F(AnnotationSetsTest, AnAuthorSavesAtMostTwentyPerScan) {
  for (int i = 0; i < AnnotationSets::kMostSets; ++i) added(owner);
  EXPECT_EQ(refusal(sets.add(owner, id, named("One more"))), ProblemKind::kTooMany);
}

TEST_F(AnnotationSetsTest, SaysThatTheScanWasDeletedMeanwhile) {
  store.break_function("add", ErrorCode::kNotFound);
  const auto added = sets.add(owner, id, named("a"));
  ASSERT_EQ(refusal(added), ProblemKind::kNotFound);
  EXPECT_EQ(added.error().detail, "The scan has been deleted.");
}

TEST_F(AnnotationSetsTest, ReportsAnUnavailableDatabase) {
  const std::string set = added(owner);
  expect_unavailable({{store, "list", [&] { return refusal(sets.list(owner, id)); }},
                      {store, "add", [&] { return refusal(sets.add(owner, id, named("a"))); }},
                      {store, "change", [&] { return refusal(sets.change(owner, id, set, {})); }},
                      {store, "remove", [&] { return refusal(sets.remove(owner, id, set)); }}});
}

}  // namespace
}  // namespace diaphane::api
