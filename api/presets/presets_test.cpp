#include "api/presets/presets.h"

#include "tests/support/api/data_set_fixture.h"
#include "tests/support/api/fake_preset_store.h"

namespace diaphane::api {
namespace {

class PresetsTest : public DataSetFixture {
 protected:
  PresetsTest() {
    signals.subscribe(Signal::kDisposal, [this] { ++disposals; });
    signals.subscribe(Signal::kPicture, [this] { ++pictures; });
    reset();
  }
  /// Restores the preset of `editor`.
  void reset() {
    store.presets.clear();
    Preset preset;
    preset.id = preset_id;
    preset.data_set_id = id;
    preset.author_id = editor.user_id;
    preset.name = "Bones";
    preset.version = 3;
    store.presets[preset_id] = preset;
  }
  void take_down() { store.presets[preset_id].taken_down = true; }
  static Preset named(const std::string& name, const std::string& scene = "{}") {
    Preset preset;
    preset.name = name;
    preset.scene = scene;
    return preset;
  }

  const Principal editor = as(Role::kSharedEdit);
  const std::string preset_id = new_id();
  int disposals = 0, pictures = 0;
  FakePresetStore store;
  Presets presets{data_sets, store, clock, signals};
};

TEST_F(PresetsTest, ThoseWhoMayViewAScanSeeItsPresets) {
  expect_permission(Action::kLook,
                    [&](const Principal& who) { return refusal(presets.list(who, id)); });
  expect_permission(Action::kLook,
                    [&](const Principal& who) { return refusal(presets.find(who, preset_id)); });
  EXPECT_EQ(presets.list(owner, id)->size(), 1u);
  EXPECT_EQ(presets.find(owner, preset_id)->name, "Bones");
}

TEST_F(PresetsTest, PresetOfAnInvisibleScanIsNotFound) {
  const auto of_a_private_scan = presets.find(stranger, preset_id);
  for (const std::string& none : {std::string("no id"), new_id()}) {
    const auto missing = presets.find(owner, none);
    ASSERT_EQ(refusal(missing), ProblemKind::kNotFound);
    EXPECT_EQ(missing.error().detail, of_a_private_scan.error().detail);
  }
}

TEST_F(PresetsTest, OnlyItsAuthorAndAdministratorsSeeAPresetThatWasTakenDown) {
  expose(Exposure::kPublic);
  take_down();
  for (const auto& [who, sees] : {std::pair(editor, true), std::pair(administrator, true),
                                  std::pair(owner, false), std::pair(stranger, false)}) {
    EXPECT_EQ(presets.list(who, id)->size(), sees ? 1u : 0u) << who.user_id;
    EXPECT_EQ(refusal(presets.find(who, preset_id)), sees ? Refusal() : ProblemKind::kNotFound)
        << who.user_id;
  }
}

TEST_F(PresetsTest, PresetBelongsToItsAuthor) {
  Preset wanted = named("Skin", "scene");
  wanted.author_id = "someone else";
  wanted.kept_xml = "<xml/>";
  const auto made = presets.add(editor, id, wanted, "");
  ASSERT_TRUE(made);
  EXPECT_TRUE(is_id(made->id));
  EXPECT_EQ(made->author_id, editor.user_id);
  EXPECT_EQ(made->data_set_id, id);
  EXPECT_EQ(made->created_at, clock.wall());
  EXPECT_EQ(made->scene, "scene");
  EXPECT_EQ(made->kept_xml, "<xml/>");
  EXPECT_EQ(disposals, 1);
  EXPECT_EQ(pictures, 1) << "its preview image is due";
}

TEST_F(PresetsTest, SavingNeedsItsPermission) {
  expect_permission(Action::kSavePreset, [&](const Principal& who) {
    return refusal(presets.add(who, id, named("Skin"), ""));
  });
}

TEST_F(PresetsTest, ARepeatedRequestWithItsKeySavesNothing) {
  const auto first = presets.add(editor, id, named("Skin"), "key");
  ASSERT_TRUE(first);
  EXPECT_EQ(presets.add(editor, id, named("Skin"), "key")->id, first->id);
  EXPECT_NE(presets.add(editor, id, named("Skin"), "")->id, first->id);
  EXPECT_EQ(refusal(presets.add(editor, id, named("Bone"), "key")),
            ProblemKind::kIdempotencyKeyReused);
  EXPECT_EQ(refusal(presets.add(editor, id, named("Skin", "other scene"), "key")),
            ProblemKind::kIdempotencyKeyReused);
  EXPECT_EQ(refusal(presets.add(owner, add_scan(), named("Skin"), "key")),
            ProblemKind::kIdempotencyKeyReused);
  store.presets.erase(first->id);
  EXPECT_EQ(refusal(presets.add(editor, id, named("Skin"), "key")), ProblemKind::kConflict);
}

TEST_F(PresetsTest, AFullListOfPresetsIsReported) {
  store.break_function("add", ErrorCode::kTooMany);
  EXPECT_EQ(refusal(presets.add(editor, id, named("Skin"), "")), ProblemKind::kTooMany);
  EXPECT_EQ(disposals + pictures, 0);
}

TEST_F(PresetsTest, OnlyItsAuthorChangesAPreset) {
  expose(Exposure::kPublic);
  const PresetChange change{.name = "Skull", .scene = {}};
  for (const Principal& who : {owner, stranger, administrator}) {
    EXPECT_EQ(refusal(presets.change(who, preset_id, 3, change)), ProblemKind::kForbidden);
  }
  const auto changed = presets.change(editor, preset_id, 3, change);
  ASSERT_TRUE(changed);
  EXPECT_EQ(changed->name, "Skull");
  EXPECT_EQ(changed->updated_at, clock.wall());
  EXPECT_EQ(disposals, 1);
  EXPECT_EQ(pictures, 1);
}

TEST_F(PresetsTest, AuthorWithViewAccessOnlyCannotChangeThePreset) {
  data_set_store.roles[{editor.user_id, id}] = Role::kSharedView;
  EXPECT_EQ(refusal(presets.change(editor, preset_id, 3, {})), ProblemKind::kForbidden);
  EXPECT_TRUE(presets.remove(editor, preset_id, 3)) << "but deletes what is theirs";
  EXPECT_EQ(disposals, 1) << "its preview image goes at once";
}

TEST_F(PresetsTest, ChangeRequiresTheCurrentVersion) {
  EXPECT_EQ(refusal(presets.change(editor, preset_id, 2, {})), ProblemKind::kPrecondition);
  EXPECT_EQ(refusal(presets.remove(editor, preset_id, 2)), ProblemKind::kPrecondition);
  EXPECT_EQ(disposals + pictures, 0);
  store.break_function("change", ErrorCode::kNotFound);
  EXPECT_EQ(refusal(presets.change(editor, preset_id, 3, {})), ProblemKind::kNotFound);
}

TEST_F(PresetsTest, ItsAuthorTheOwnerOfTheScanAndAdministratorsDeleteAPreset) {
  struct Case {
    Exposure exposure;
    Role role;
    Refusal expected;
  };
  for (const Case& one : {
           Case{Exposure::kPrivate, Role::kSharedEdit, {}},
           Case{Exposure::kPrivate, Role::kOwner, {}},
           Case{Exposure::kPrivate, Role::kSharedView, ProblemKind::kForbidden},
           Case{Exposure::kPrivate, Role::kAdministrator, ProblemKind::kNotFound},
           Case{Exposure::kPrivate, Role::kOther, ProblemKind::kNotFound},
           Case{Exposure::kPublic, Role::kOwner, {}},
           Case{Exposure::kPublic, Role::kAdministrator, {}},
           Case{Exposure::kPublic, Role::kOther, ProblemKind::kForbidden},
           Case{Exposure::kTakenDown, Role::kAdministrator, {}},
           Case{Exposure::kTakenDown, Role::kSharedEdit, ProblemKind::kNotFound},
       }) {
    reset();
    expose(one.exposure);
    EXPECT_EQ(refusal(presets.remove(as(one.role), preset_id, 3)), one.expected)
        << to_string(one.role) << ", exposure " << static_cast<int>(one.exposure);
    EXPECT_EQ(store.presets.contains(preset_id), one.expected.has_value());
  }
}

TEST_F(PresetsTest, DatabaseOutageIsNotReportedAsMissingPermission) {
  for (const int failing : {2, 3}) {
    reset();
    expose(Exposure::kPublic);
    const int before = data_set_store.calls("find");
    data_set_store.before("find", [&] {
      if (data_set_store.calls("find") == before + failing) data_set_store.break_function("find");
    });
    EXPECT_EQ(refusal(presets.remove(administrator, preset_id, 3)), ProblemKind::kUnavailable);
    EXPECT_TRUE(store.presets.contains(preset_id));
    data_set_store.repair("find");
  }
}

TEST_F(PresetsTest, VotingNeedsItsPermission) {
  expect_permission(Action::kVote, [&](const Principal& who) {
    const auto voted = presets.vote(who, preset_id, 1);
    if (voted) EXPECT_EQ(voted->my_vote, 1);
    // Users who may not even view the scan get the same answer as for a missing preset.
    return refusal(voted);
  });
}

TEST_F(PresetsTest, APresetThatWasTakenDownGetsNoVotes) {
  expose(Exposure::kPublic);
  take_down();
  EXPECT_EQ(refusal(presets.vote(editor, preset_id, 1)), ProblemKind::kForbidden);
  EXPECT_EQ(refusal(presets.vote(stranger, preset_id, 1)), ProblemKind::kNotFound);
  EXPECT_EQ(store.presets[preset_id].my_vote, 0);
}

TEST_F(PresetsTest, TheOwnerOfAScanChoosesItsDefault) {
  expect_permission(Action::kDescribe, [&](const Principal& who) {
    return refusal(presets.set_default(who, id, preset_id));
  });
  EXPECT_EQ(store.defaults[id], preset_id);
  for (const std::string& none : {std::string("no id"), new_id()}) {
    EXPECT_EQ(refusal(presets.set_default(owner, id, none)), ProblemKind::kNotFound);
  }
  EXPECT_EQ(store.defaults[id], preset_id);
  EXPECT_TRUE(presets.set_default(owner, id, ""));
  EXPECT_EQ(store.defaults[id], "");
}

TEST_F(PresetsTest, ReportsAnUnavailableDatabase) {
  expose(Exposure::kPublic);
  const auto find = [&] { return refusal(presets.find(owner, preset_id)); };
  const auto add = [&] { return refusal(presets.add(editor, id, named("Skin"), "")); };
  const auto change = [&] { return refusal(presets.change(editor, preset_id, 3, {})); };
  const auto remove = [&] { return refusal(presets.remove(editor, preset_id, 3)); };
  const auto vote = [&] { return refusal(presets.vote(owner, preset_id, 1)); };
  const auto set = [&] { return refusal(presets.set_default(owner, id, preset_id)); };
  expect_unavailable({
      {data_set_store, "find", [&] { return refusal(presets.list(owner, id)); }},
      {store, "list", [&] { return refusal(presets.list(owner, id)); }},
      {store, "find", find},
      {data_set_store, "find", find},
      {data_set_store, "find", add},
      {store, "add", add},
      {store, "find", add},
      {store, "find", change},
      {store, "change", change},
      {store, "find", remove},
      {store, "remove", remove},
      {store, "find", vote},
      {store, "vote", vote},
      {data_set_store, "find", set},
      {store, "set_default", set},
  });
}

}  // namespace
}  // namespace diaphane::api
