#include "api/scans/thumbnails.h"

#include <future>

#include "tests/support/api/data_set_fixture.h"
#include "tests/support/api/fake_stills.h"
#include "tests/support/api/temporary_directory.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

class ThumbnailsTest : public DataSetFixture {
 protected:
  std::string path_of(const std::string& preset) const {
    return "thumbnails/" + id + "/" + preset + ".7.jpg";
  }
  Refusal get(const std::string& preset = "bone") {
    return refusal(thumbnails.get(owner, id, preset));
  }

  const TemporaryDirectory cache;
  FakeStills stills;
  /// Two thumbnails at a time. A request waits a moment for the rendering of another request.
  Thumbnails thumbnails{data_sets, stills, cache.path(), 2, 1ms};
};

TEST_F(ThumbnailsTest, ThoseWhoMayViewAScanGetItsThumbnails) {
  expect_permission(Action::kLook,
                    [&](const Principal& who) { return refusal(thumbnails.get(who, id, "bone")); });
}

TEST_F(ThumbnailsTest, APictureOfAScanThatIsNotPublicIsInTheAuditLog) {
  const auto looked = [&](const Principal& who) {
    data_set_store.accesses.clear();
    EXPECT_TRUE(thumbnails.get(who, id, "bone"));
    return data_set_store.accesses;
  };
  EXPECT_TRUE(looked(owner).empty());
  const auto by_person = looked(shared);
  ASSERT_EQ(by_person.size(), 1u);
  EXPECT_EQ(by_person[0].action, "data-set.picture-looked-at");
  EXPECT_EQ(by_person[0].actor_id, shared.user_id);
  EXPECT_EQ(by_person[0].subject_id, id);
  EXPECT_EQ(details_as_json(by_person[0].details), R"({"by":"person"})");
  expose(Exposure::kTakenDown);
  const auto by_administrator = looked(administrator);
  ASSERT_EQ(by_administrator.size(), 1u);
  EXPECT_EQ(by_administrator[0].actor, AuditActor::kAdministrator);
  expose(Exposure::kPublic);
  EXPECT_TRUE(looked(shared).empty());
  expose(Exposure::kPrivate);
  data_set_store.break_function("note_access");
  EXPECT_EQ(refusal(thumbnails.get(shared, id, "bone")), ProblemKind::kUnavailable);
}

TEST_F(ThumbnailsTest, AVisitorWithALinkGetsThumbnailsWhileItLeadsThere) {
  const auto leads = [&]() -> Outcome<Thumbnails::Linked> {
    auto found = data_sets.find_ready(shared, id);
    DIAPHANE_TRY(found);
    return Thumbnails::Linked{*found, "link-id"};
  };
  EXPECT_EQ(thumbnails.get_with_link(leads, "bone").value(), path_of("bone"));
  ASSERT_EQ(data_set_store.accesses.size(), 1u);
  EXPECT_EQ(data_set_store.accesses[0].action, "data-set.picture-looked-at");
  EXPECT_EQ(data_set_store.accesses[0].actor_id, "");
  EXPECT_EQ(details_as_json(data_set_store.accesses[0].details),
            R"({"by":"link","link":"link-id"})");
  EXPECT_EQ(refusal(thumbnails.get_with_link(leads, "none")), ProblemKind::kNotFound);

  const auto ended = []() -> Outcome<Thumbnails::Linked> {
    return refuse(ProblemKind::kNotFound, "No such link.");
  };
  EXPECT_EQ(refusal(thumbnails.get_with_link(ended, "bone")), ProblemKind::kNotFound);
  int calls = 0;  // the link ends while the thumbnail is rendered
  const auto ends = [&] { return ++calls == 1 ? leads() : ended(); };
  EXPECT_EQ(refusal(thumbnails.get_with_link(ends, "skin")), ProblemKind::kNotFound);
  EXPECT_EQ(calls, 2);
  expose(Exposure::kPublic);
  data_set_store.accesses.clear();
  EXPECT_TRUE(thumbnails.get_with_link(leads, "bone"));
  EXPECT_TRUE(data_set_store.accesses.empty());
}

TEST_F(ThumbnailsTest, AThumbnailIsRenderedOnceForEachPreset) {
  const auto presets = {"skin",    "muscle", "vessels", "bone",
                        "through", "dense",  "airways", "brain"};
  for (const char* preset : presets) {
    EXPECT_EQ(thumbnails.get(owner, id, preset).value(), path_of(preset));
    EXPECT_EQ(thumbnails.get(shared, id, preset).value(), path_of(preset));
    EXPECT_EQ(stills.requests().back().preset, preset);
    EXPECT_EQ(stills.requests().back().data_set_id, id);
    EXPECT_FALSE(stills.requests().back().background) << "somebody waits for it";
    EXPECT_EQ(cache.read(path_of(preset)), "image of " + id + " " + preset);
  }
  EXPECT_EQ(stills.requests().size(), presets.size());
}

TEST_F(ThumbnailsTest, ThumbnailOfOutdatedPresetsIsNotShownAndDeleted) {
  const std::string directory = "thumbnails/" + id + "/", of_another = "thumbnails/other/bone.jpg";
  for (const char* old : {"bone.jpg", "skin.jpg", "bone.1.jpg"})
    cache.write(directory + old, "old");
  cache.write(directory + ".tmp-1", "being written");
  cache.write(of_another, "of another scan");
  EXPECT_EQ(thumbnails.get(owner, id, "bone").value(), path_of("bone"));
  EXPECT_EQ(cache.read(path_of("bone")), "image of " + id + " bone");
  for (const char* old : {"bone.jpg", "skin.jpg", "bone.1.jpg"}) {
    EXPECT_FALSE(cache.has(directory + old)) << old;
  }
  EXPECT_TRUE(cache.has(directory + ".tmp-1"));
  EXPECT_TRUE(cache.has(of_another));
  EXPECT_EQ(get("skin"), Refusal());
  EXPECT_TRUE(cache.has(path_of("bone"))) << "a current one stays";
}

TEST_F(ThumbnailsTest, OnlyKnownPresetsOfScansThatAreReadyHaveThumbnails) {
  for (const char* unknown : {"", "liver", "../bone"}) {
    EXPECT_EQ(get(unknown), ProblemKind::kNotFound);
  }
  scan().state = DataSetState::kBuilding;
  EXPECT_EQ(get(), ProblemKind::kNotReady);
  EXPECT_TRUE(stills.requests().empty());
}

TEST_F(ThumbnailsTest, AThumbnailFromBeforeTheScanWasAnonymisedIsNotShown) {
  EXPECT_EQ(get(), Refusal());
  scan().anonymised_at = std::chrono::system_clock::now();
  fs::last_write_time(fs::path(cache.path()) / path_of("bone"),
                      std::chrono::file_clock::from_sys(*scan().anonymised_at - 1s));
  EXPECT_EQ(get(), Refusal());
  EXPECT_EQ(stills.requests().size(), 2u);
  fs::last_write_time(fs::path(cache.path()) / path_of("bone"),
                      std::chrono::file_clock::from_sys(*scan().anonymised_at + 1s));
  EXPECT_EQ(get(), Refusal());
  EXPECT_EQ(stills.requests().size(), 2u) << "it shows what is left";
}

TEST_F(ThumbnailsTest, EachWorkerFailureHasItsOwnError) {
  for (const auto& [code, kind] : {std::pair(ErrorCode::kUnavailable, ProblemKind::kNoWorker),
                                   std::pair(ErrorCode::kNotFound, ProblemKind::kNotFound),
                                   std::pair(ErrorCode::kInternal, ProblemKind::kInternal)}) {
    stills.break_function("render", code);
    EXPECT_EQ(get(), kind);
  }
  stills.break_function("render");
  EXPECT_EQ(thumbnails.get(owner, id, "bone").error().retry_after, 2s);
  stills.repair("render");
  EXPECT_EQ(get(), Refusal()) << "no failure holds a place";
}

TEST_F(ThumbnailsTest, ExceptionFreesTheRenderingSlot) {
  stills.before("render", [] { throw std::runtime_error("a bug"); });
  for (int i = 0; i < 3; ++i) EXPECT_THROW(get(), std::runtime_error);
  stills.before("render", [] {});
  EXPECT_EQ(get(), Refusal());
}

TEST_F(ThumbnailsTest, ACacheThatCannotBeWrittenIsUnavailable) {
  cache.write("thumbnails", "a file where the directory belongs");
  EXPECT_EQ(get(), ProblemKind::kUnavailable);
}

TEST_F(ThumbnailsTest, RefusesTheThirdConcurrentThumbnail) {
  Refusal second = ProblemKind::kInternal, third;
  stills.before("render", [&] {
    const std::size_t started = stills.requests().size();
    if (started == 1) second = get("skin");
    if (started == 2) third = get("muscle");
  });
  EXPECT_EQ(get("bone"), Refusal());
  EXPECT_EQ(second, Refusal());
  EXPECT_EQ(third, ProblemKind::kBusy);
  stills.before("render", [] {});
  EXPECT_EQ(get("muscle"), Refusal());
}

TEST_F(ThumbnailsTest, ARequestWaitsOnlyAWhileForTheRenderingOfAnother) {
  Refusal same;
  stills.before("render", [&] { same = get("bone"); });
  EXPECT_EQ(get("bone"), Refusal());
  EXPECT_EQ(same, ProblemKind::kBusy);
  EXPECT_EQ(stills.requests().size(), 1u);
}

TEST_F(ThumbnailsTest, TwoRequestsWaitForTheRenderingOfAnotherAndTheThirdIsRefused) {
  Thumbnails patient(data_sets, stills, cache.path(), 2, 1min);
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<Refusal> answers;
  std::vector<std::future<void>> others;
  stills.before("render", [&] {
    for (int i = 0; i < 3; ++i) {
      others.push_back(std::async(std::launch::async, [&] {
        const Refusal answer = refusal(patient.get(owner, id, "bone"));
        const std::lock_guard lock(mutex);
        answers.push_back(answer);
        changed.notify_all();
      }));
    }
    // The two others wait until this image is done.
    std::unique_lock lock(mutex);
    EXPECT_TRUE(changed.wait_for(lock, 30s, [&] { return !answers.empty(); }));
  });
  EXPECT_TRUE(patient.get(owner, id, "bone"));
  others.clear();
  EXPECT_EQ(answers, (std::vector<Refusal>{ProblemKind::kBusy, {}, {}}));
  EXPECT_EQ(stills.requests().size(), 1u);
}

TEST_F(ThumbnailsTest, NothingIsLeftOfAScanThatWasDeletedDuringTheRendering) {
  stills.before("render", [&] { data_set_store.data_sets.erase(id); });
  EXPECT_EQ(get(), ProblemKind::kNotFound);
  EXPECT_FALSE(cache.has(path_of("bone")));
}

TEST_F(ThumbnailsTest, NothingIsShownOfAScanThatWasAnonymisedDuringTheRendering) {
  stills.before("render", [&] { scan().anonymised_at = clock.wall(); });
  EXPECT_EQ(get(), ProblemKind::kBusy);
  EXPECT_FALSE(cache.has(path_of("bone")));
}

TEST_F(ThumbnailsTest, RemovingDeletesAllFilesAndMayBeRepeated) {
  EXPECT_EQ(get("bone"), Refusal());
  EXPECT_EQ(get("skin"), Refusal());
  cache.write("thumbnails/other/bone.jpg", "of another scan");
  EXPECT_TRUE(thumbnails.remove(id));
  EXPECT_FALSE(cache.has("thumbnails/" + id));
  EXPECT_TRUE(cache.has("thumbnails/other/bone.jpg"));
  EXPECT_TRUE(thumbnails.remove(id));
}

TEST_F(ThumbnailsTest, ReportsAnUnavailableDatabase) {
  expect_unavailable({{data_set_store, "find", [&] { return get(); }}});
}

}  // namespace
}  // namespace diaphane::api
