#include "api/presets/preset_pictures.h"

#include "tests/support/api/data_set_fixture.h"
#include "tests/support/api/fake_preset_store.h"
#include "tests/support/api/fake_stills.h"
#include "tests/support/api/temporary_directory.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;

class PresetPicturesTest : public DataSetFixture {
 protected:
  PresetPicturesTest() {
    Preset& preset = store.presets[preset_id];
    preset.id = preset_id;
    preset.data_set_id = id;
    preset.author_id = owner.user_id;
    store.due = PresetPicture{preset_id, id, "scene", {}};
  }
  /// Lets the image be rendered as if in the background.
  void render() {
    ASSERT_TRUE(pictures.make_next());
    ASSERT_TRUE(cache.has(path));
  }

  const std::string preset_id = new_id();
  const std::string path = "presets/" + preset_id + "/picture.jpg";
  const TemporaryDirectory cache;
  FakePresetStore store;
  FakeStills stills;
  Presets presets{data_sets, store, clock, signals};
  PresetPictures pictures{
      data_sets, presets, store, stills, clock, cache.path(), [](const std::string& scene) {
        return scene == "of another version" ? "" : "bytes of " + scene;
      }};
};

TEST_F(PresetPicturesTest, ThoseWhoMayViewTheScanGetTheImage) {
  render();
  expect_permission(Action::kLook, [&](const Principal& who) {
    return refusal(pictures.get(who, id, preset_id));
  });
  EXPECT_EQ(pictures.get(owner, id, preset_id).value(), path);
}

TEST_F(PresetPicturesTest, AnImageOfAScanThatIsNotPublicIsInTheAuditLog) {
  EXPECT_EQ(refusal(pictures.get(shared, id, preset_id)), ProblemKind::kNotFound);
  EXPECT_TRUE(data_set_store.accesses.empty()) << "there is nothing to see yet";
  store.presets[preset_id].pictured_at = clock.wall();
  render();
  ASSERT_TRUE(pictures.get(shared, id, preset_id));
  ASSERT_EQ(data_set_store.accesses.size(), 1u);
  EXPECT_EQ(data_set_store.accesses[0].action, "data-set.picture-looked-at");
}

TEST_F(PresetPicturesTest, ThereIsNoImageOfAnotherScanOrAMissingPreset) {
  render();
  EXPECT_EQ(refusal(pictures.get(owner, add_scan(), preset_id)), ProblemKind::kNotFound);
  EXPECT_EQ(refusal(pictures.get(owner, id, new_id())), ProblemKind::kNotFound);
}

TEST_F(PresetPicturesTest, AnImageOfAPresetThatWasTakenDownIsHiddenWithIt) {
  render();
  store.presets[preset_id].taken_down = true;
  expose(Exposure::kPublic);
  EXPECT_TRUE(pictures.get(owner, id, preset_id)) << "the author still sees it";
  EXPECT_EQ(refusal(pictures.get(stranger, id, preset_id)), ProblemKind::kNotFound);
}

TEST_F(PresetPicturesTest, AnImageThatIsNotRenderedYetIsNotFound) {
  EXPECT_EQ(refusal(pictures.get(owner, id, preset_id)), ProblemKind::kNotFound);
  EXPECT_TRUE(store.forgotten.empty());
}

TEST_F(PresetPicturesTest, AScanThatIsBeingProcessedShowsNoOldImages) {
  render();
  scan().state = DataSetState::kQueued;
  EXPECT_EQ(refusal(pictures.get(owner, id, preset_id)), ProblemKind::kNotFound);
}

TEST_F(PresetPicturesTest, AnImageThatTheCacheLostIsRenderedAgain) {
  render();
  ASSERT_TRUE(pictures.remove(preset_id));
  EXPECT_EQ(refusal(pictures.get(owner, id, preset_id)), ProblemKind::kNotFound);
  EXPECT_EQ(store.forgotten, std::vector{preset_id});
}

TEST_F(PresetPicturesTest, RendersSceneOfThePresetAtBackgroundPriority) {
  render();
  ASSERT_EQ(stills.requests().size(), 1u);
  const StillRequest request = stills.requests()[0];
  EXPECT_EQ(request.data_set_id, id);
  EXPECT_EQ(request.scene, "bytes of scene");
  EXPECT_TRUE(request.background);
  EXPECT_EQ(store.lease, 90s) << "longer than a worker may take";
  EXPECT_EQ(cache.read(path), "image of " + id + " bytes of scene");
  EXPECT_EQ(store.presets[preset_id].pictured_at, clock.wall());
}

TEST_F(PresetPicturesTest, DoesNothingWithoutADueImageOrADatabase) {
  store.due.reset();
  EXPECT_FALSE(pictures.make_next());
  store.break_function("claim_picture");
  EXPECT_FALSE(pictures.make_next());
  EXPECT_TRUE(stills.requests().empty());
}

TEST_F(PresetPicturesTest, ASceneOfAnotherVersionIsSkippedWithoutAWorker) {
  store.due->scene = "of another version";
  EXPECT_TRUE(pictures.make_next()) << "the next one may be rendered";
  EXPECT_TRUE(stills.requests().empty());
  EXPECT_EQ(store.calls("keep_picture"), 0);
}

TEST_F(PresetPicturesTest, WithoutAWorkerTheImageIsDueAgainInTenSeconds) {
  stills.break_function("render");
  EXPECT_FALSE(pictures.make_next());
  EXPECT_EQ(store.postponed[preset_id], clock.wall() + 10s);
}

TEST_F(PresetPicturesTest, AnImageThatNoWorkerCanRenderDoesNotHoldUpTheNext) {
  for (const ErrorCode code : {ErrorCode::kNotFound, ErrorCode::kInternal}) {
    stills.break_function("render", code);
    EXPECT_TRUE(pictures.make_next());
  }
  EXPECT_TRUE(store.postponed.empty()) << "the lease is the pause, and grows with each failure";
  EXPECT_EQ(store.calls("keep_picture"), 0);
}

TEST_F(PresetPicturesTest, AnImageOfAPresetThatChangedMeanwhileIsDiscarded) {
  store.picture_is_wanted = false;
  EXPECT_TRUE(pictures.make_next());
  EXPECT_FALSE(cache.has(path));
}

TEST_F(PresetPicturesTest, RenderingPausesIfImagesCannotBeSaved) {
  store.break_function("keep_picture");
  EXPECT_FALSE(pictures.make_next());
  store.repair("keep_picture");
  cache.write("presets", "a file where the directory belongs");
  EXPECT_FALSE(pictures.make_next());
  EXPECT_FALSE(store.presets[preset_id].pictured_at);
}

TEST_F(PresetPicturesTest, RemovingDeletesTheFileAndMayBeRepeated) {
  render();
  EXPECT_TRUE(pictures.remove(preset_id));
  EXPECT_FALSE(cache.has("presets/" + preset_id));
  EXPECT_TRUE(pictures.remove(preset_id));
}

TEST_F(PresetPicturesTest, ReportsAnUnavailableDatabase) {
  const auto get = [&] { return refusal(pictures.get(owner, id, preset_id)); };
  expect_unavailable({{store, "find", get}, {data_set_store, "find", get}});
}

}  // namespace
}  // namespace diaphane::api
