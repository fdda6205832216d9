#include "api/scans/alignments.h"

#include <gmock/gmock.h>

#include "tests/support/api/data_set_fixture.h"

namespace diaphane::api {
namespace {

class FakeAlignmentStore final : public AlignmentStore, public Fake {
 public:
  Alignment known;
  Request answer = Request::kMade;

  Result<Alignment> find(const std::string&, const std::string&) override {
    DIAPHANE_TRY(enter("find"));
    return known;
  }
  Result<Request> request(const std::string&, const std::string&, const std::string&, int,
                          Time) override {
    DIAPHANE_TRY(enter("request"));
    if (answer == Request::kMade) known.state = "waiting";
    return answer;
  }
  Result<bool> remove(const std::string&, const std::string&) override {
    DIAPHANE_TRY(enter("remove"));
    const bool had = known.state != "none";
    known = {};
    return had;
  }
};

class AlignmentsTest : public DataSetFixture {
 protected:
  AlignmentsTest() {
    headers[id] = header({10, 20, 30});
    headers[other] = header({-5, 0, 100});
  }
  static volume::Header header(std::array<double, 3> origin) {
    volume::Header made;
    made.size = {11, 21, 31};
    made.spacing = {1, 2, 3};
    made.origin = origin;
    return made;
  }

  const std::string other = add_scan();
  std::map<std::string, volume::Header> headers;
  FakeAlignmentStore store;
  Alignments alignments{data_sets, store, clock,
                        [this](const std::string& of) -> Result<volume::Header> {
                          const auto found = headers.find(of);
                          if (found == headers.end()) return fail(ErrorCode::kNotFound, "gone");
                          return found->second;
                        }};
};

TEST_F(AlignmentsTest, BothScansMustBeVisible) {
  data_set_store.roles[{"shared-view", other}] = Role::kSharedView;
  EXPECT_TRUE(alignments.find(shared, id, other));
  data_set_store.roles.erase({"shared-view", other});
  for (const auto& [one, two] : {std::pair(id, other), std::pair(other, id)}) {
    EXPECT_EQ(refusal(alignments.find(shared, one, two)), ProblemKind::kNotFound);
    EXPECT_EQ(refusal(alignments.request(shared, one, two)), ProblemKind::kNotFound);
    EXPECT_EQ(refusal(alignments.remove(shared, one, two)), ProblemKind::kNotFound);
    EXPECT_EQ(refusal(alignments.motion(shared, one, two)), ProblemKind::kNotFound);
  }
}

TEST_F(AlignmentsTest, OnlyTheOwnerOfOneOfTheScansAlignsThem) {
  data_set_store.roles[{"shared-view", other}] = Role::kSharedView;
  EXPECT_EQ(refusal(alignments.request(shared, id, other)), ProblemKind::kForbidden);
  EXPECT_EQ(store.calls("request"), 0);
  EXPECT_FALSE(alignments.find(shared, id, other)->may_align);
  data_set_store.roles[{"shared-view", other}] = Role::kOwner;
  EXPECT_TRUE(alignments.request(shared, id, other)->made);
  EXPECT_TRUE(alignments.find(shared, other, id)->may_align);
  data_set_store.roles[{"shared-view", other}] = Role::kSharedView;
  EXPECT_EQ(refusal(alignments.remove(shared, id, other)), ProblemKind::kForbidden);
}

TEST_F(AlignmentsTest, RequestKeepsAnAlignmentThatHasNotFailed) {
  EXPECT_TRUE(alignments.request(owner, id, other)->made);
  EXPECT_FALSE(alignments.request(owner, id, other)->made);
  store.known.state = "ready";
  EXPECT_FALSE(alignments.request(owner, id, other)->made);
  EXPECT_EQ(store.calls("request"), 1);
  store.known.state = "failed";
  EXPECT_TRUE(alignments.request(owner, id, other)->made);
}

TEST_F(AlignmentsTest, ScansWithACommonFrameOfReferenceNeedNoAlignment) {
  store.known = {.state = "ready", .shares_frame = true};
  EXPECT_FALSE(alignments.request(owner, id, other)->made);
  EXPECT_EQ(store.calls("request"), 0);
  EXPECT_EQ(alignments.motion(owner, id, other).value(), "") << "the identity";
}

TEST_F(AlignmentsTest, MotionIsKnownOnlyOnceTheScansAreAligned) {
  for (const char* state : {"none", "waiting", "running", "failed"}) {
    store.known = {.state = state};
    EXPECT_EQ(refusal(alignments.motion(owner, id, other)), ProblemKind::kNotAligned) << state;
  }
  store.known = {.state = "ready", .matrix = {0, -1, 0, 0.1, 1, 0, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1}};
  EXPECT_EQ(alignments.motion(owner, id, other).value(),
            "0 -1 0 0.10000000000000001 1 0 0 2 0 0 1 3 0 0 0 1");
}

TEST_F(AlignmentsTest, PicturesAreRelatedByTheMiddlesOfTheirBoxes) {
  store.known = {.state = "ready", .shares_frame = true};
  const auto found = alignments.find(owner, id, other);
  ASSERT_TRUE(found && found->scene_matrix);
  // The middle of a box is at its first voxel's centre + (5, 20, 45).
  const auto middle = volume::moved(*found->scene_matrix, {0, 0, 0});
  EXPECT_DOUBLE_EQ(middle[0], -15);
  EXPECT_DOUBLE_EQ(middle[1], -20);
  EXPECT_DOUBLE_EQ(middle[2], 70);
  store.known = {.state = "ready", .matrix = {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
  // (0, 20, 145) in the second scan is (-20, 0, 145) in the first, whose box is around (15, 40,
  // 75).
  const auto turned = volume::moved(*alignments.find(owner, id, other)->scene_matrix, {0, 0, 0});
  EXPECT_DOUBLE_EQ(turned[0], -35);
  EXPECT_DOUBLE_EQ(turned[1], -40);
  EXPECT_DOUBLE_EQ(turned[2], 70);
  headers.erase(other);
  EXPECT_FALSE(alignments.find(owner, id, other)->scene_matrix);
}

TEST_F(AlignmentsTest, AScanIsNotAlignedWithItself) {
  EXPECT_EQ(refusal(alignments.find(owner, id, id)), ProblemKind::kConflict);
  EXPECT_EQ(refusal(alignments.request(owner, id, id)), ProblemKind::kConflict);
}

TEST_F(AlignmentsTest, RefusesScansThatAreNotReadyAndTooManyRequests) {
  data_set_store.data_sets[other].state = DataSetState::kBuilding;
  EXPECT_EQ(refusal(alignments.find(owner, id, other)), ProblemKind::kNotReady);
  data_set_store.data_sets[other].state = DataSetState::kReady;
  store.answer = AlignmentStore::Request::kTooMany;
  EXPECT_EQ(refusal(alignments.request(owner, id, other)), ProblemKind::kTooMany);
  store.answer = AlignmentStore::Request::kNotReady;
  EXPECT_EQ(refusal(alignments.request(owner, id, other)), ProblemKind::kNotReady);
  store.answer = AlignmentStore::Request::kKnown;
  EXPECT_FALSE(alignments.request(owner, id, other)->made) << "another request was first";
}

TEST_F(AlignmentsTest, RemoveForgetsAnAlignment) {
  EXPECT_EQ(refusal(alignments.remove(owner, id, other)), ProblemKind::kNotFound);
  store.known.state = "ready";
  EXPECT_TRUE(alignments.remove(owner, id, other));
  EXPECT_EQ(alignments.find(owner, id, other)->state, "none");
}

TEST_F(AlignmentsTest, ReportsAnUnavailableDatabase) {
  expect_unavailable({
      {store, "find", [&] { return refusal(alignments.find(owner, id, other)); }},
      {store, "request", [&] { return refusal(alignments.request(owner, id, other)); }},
      {store, "remove", [&] { return refusal(alignments.remove(owner, id, other)); }},
  });
}

}  // namespace
}  // namespace diaphane::api
