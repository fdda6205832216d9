#include "api/studies/participation.h"

#include <nlohmann/json.hpp>

#include "tests/support/api/data_set_fixture.h"
#include "tests/support/api/fake_render_time_store.h"
#include "tests/support/api/fake_study_stores.h"

namespace diaphane::api {
namespace {

using nlohmann::json;

class ParticipationTest : public DataSetFixture {
 protected:
  ParticipationTest() {
    store.study.id = new_id();
    store.study.owner_id = owner.user_id;
    store.study.content.places = 2;
    store.study.content.ends_at = clock.wall() + std::chrono::hours(1);
    const json view{{"data_set_id", id}, {"scene", {{"a", 1}}}};
    store.study.content.definition =
        json{{"record", true},
             {"steps",
              {{{"id", "consent"}, {"kind", "consent"}},
               {{"id", "rate"}, {"kind", "rating"}, {"low", 0}, {"high", 10}},
               {{"id", "look"}, {"kind", "viewpoint"}, {"view", view}},
               {{"id", "again"}, {"kind", "viewpoint"}, {"view", view}}}}}
            .dump();
  }
  Outcome<Participations::Joined> join(const std::string& with, bool record = false) {
    return participations.join(token, with, "en", record, {"192.0.2.1", ""});
  }
  Refusal rate(const json& value) {
    return refusal(participations.answer(key, {"rate", "", 1, 1}, value));
  }

  const std::string token = std::string(64, 'a'), key = std::string(64, 'b'),
                    other = std::string(64, 'c');
  FakeStudies store;
  FakeAccountStore accounts;
  FakeRenderTimeStore render_time_store;
  FakeSpentRenderTime spent;
  RenderTime render_time{render_time_store, spent, placement, clock};
  const SealingKey secret = *SealingKey::of_hex(std::string(64, '7'));
  Participations participations = process(secret);

  /// Returns the service as another process of the API has it.
  Participations process(const SealingKey& with) {
    return {{store, store, data_sets, accounts, render_time, placement, clock, with},
            {.joins_by_address = 2},
            [](const std::string& scene) { return "bytes of " + scene; }};
  }
};

TEST_F(ParticipationTest, StoresOnlyAHashOfTheKey) {
  ASSERT_TRUE(join(key));
  ASSERT_EQ(store.people.size(), 1U);
  EXPECT_NE(store.people.begin()->first, key);
  EXPECT_LT(store.people.begin()->second.seed, kSeeds);
}

TEST_F(ParticipationTest, LimitsNewParticipantsPerAddressButNotReturningOnes) {
  store.study.content.places = 10;
  ASSERT_TRUE(join(key));
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(join(key)) << "a reload is not a new participant";
  ASSERT_TRUE(join(other));
  EXPECT_EQ(refusal(join(std::string(64, 'd'))), ProblemKind::kTooManyAttempts);
}

TEST_F(ParticipationTest, CountsTheParticipantsOfAnAddressInAllProcessesTogether) {
  store.study.content.places = 10;
  const SealingKey same = *SealingKey::of_hex(std::string(64, '7'));
  Participations second = process(same);
  ASSERT_TRUE(join(key));
  ASSERT_TRUE(second.join(token, other, "en", false, {"192.0.2.1", ""}));
  EXPECT_EQ(refusal(join(std::string(64, 'd'))), ProblemKind::kTooManyAttempts);
  EXPECT_EQ(refusal(second.join(token, std::string(64, 'e'), "en", false, {"192.0.2.1", ""})),
            ProblemKind::kTooManyAttempts);
  EXPECT_TRUE(second.join(token, std::string(64, 'f'), "en", false, {"192.0.2.2", ""}));
}

TEST_F(ParticipationTest, RefusesWhenFullOrClosed) {
  store.study.content.places = 1;
  ASSERT_TRUE(join(key));
  EXPECT_EQ(refusal(join(other)), ProblemKind::kStudyFull);
  store.open = false;
  EXPECT_EQ(refusal(join(other)), ProblemKind::kStudyClosed);
  EXPECT_EQ(rate({{"rating", 1}}), ProblemKind::kStudyClosed);
}

TEST_F(ParticipationTest, ChecksAnswersAgainstTheirStep) {
  EXPECT_EQ(rate({{"rating", 1}}), ProblemKind::kParticipationEnded);
  ASSERT_TRUE(join(key));
  EXPECT_EQ(rate({{"rating", 1}}), Refusal());
  for (const json& wrong : {json{{"rating", 11}}, json{{"rating", "1"}}, json::object(), json(1)}) {
    EXPECT_EQ(rate(wrong), ProblemKind::kInvalid) << wrong;
  }
  EXPECT_EQ(store.calls("answer"), 1);
}

TEST_F(ParticipationTest, TheResearcherPaysForTheSessionOfAParticipant) {
  ASSERT_TRUE(join(key));
  const auto opened = participations.visit(key, "look");
  ASSERT_TRUE(opened);
  const PlaceRequest& request = placement.requests.back();
  EXPECT_EQ(request.user_id, store.people.begin()->second.id) << "the researcher can't watch it";
  EXPECT_EQ(request.charged_to, owner.user_id);
  EXPECT_EQ(request.viewer, SessionViewer::kLinkVisitor);
  EXPECT_EQ(request.first_scene, "bytes of {\"a\":1}");
  EXPECT_FALSE(request.slices || request.downloads || request.visitor);
  EXPECT_EQ(opened->expires_at, store.study.content.ends_at);
  render_time_store.accounts[owner.user_id] = {};
  EXPECT_EQ(refusal(participations.visit(key, "again")), ProblemKind::kBusy)
      << "the quota of the researcher is not told to participants";
}

TEST_F(ParticipationTest, AParticipantHasOneSession) {
  ASSERT_TRUE(join(key));
  const auto first = participations.visit(key, "look");
  ASSERT_TRUE(first);
  EXPECT_EQ(participations.visit(key, "look")->session_id, first->session_id);
  ASSERT_TRUE(participations.visit(key, "again"));
  EXPECT_EQ(placement.ended, std::vector{first->session_id});
}

TEST_F(ParticipationTest, AVisitThatAnotherOneOvertakesLeavesNoSession) {
  ASSERT_TRUE(join(key));
  bool nested = false;
  std::string later;
  placement.before("place", [&] {
    if (std::exchange(nested, true)) return;
    later = participations.visit(key, "again")->session_id;
  });
  EXPECT_EQ(refusal(participations.visit(key, "look")), ProblemKind::kBusy);
  ASSERT_EQ(placement.sessions.size(), 1U);
  EXPECT_EQ(placement.sessions.begin()->first, later);
}

TEST_F(ParticipationTest, TheEarlierSessionIsNotForgottenIfItCanNotBeEnded) {
  ASSERT_TRUE(join(key));
  const auto first = participations.visit(key, "look");
  placement.break_function("end");
  EXPECT_EQ(refusal(participations.visit(key, "again")), ProblemKind::kUnavailable);
  EXPECT_EQ(store.people.begin()->second.session_id, first->session_id);
}

TEST_F(ParticipationTest, ARepeatedAttemptToJoinCountsOnce) {
  store.study.content.places = 10;
  store.break_function("join");
  for (int i = 0; i < 5; ++i) EXPECT_EQ(refusal(join(key)), ProblemKind::kUnavailable);
  store.repair("join");
  ASSERT_TRUE(join(other)) << "two places per address";
  for (const auto& [hash, at] : accounts.attempts) {
    EXPECT_EQ(at.time_since_epoch() % std::chrono::minutes(15), Time::duration(0));
    EXPECT_NE(hash, blake2b("study:192.0.2.1"));
  }
}

TEST_F(ParticipationTest, AClosedStudyAndAWithdrawalHaveDifferentProblems) {
  ASSERT_TRUE(join(key));
  store.before("answer", [&] { store.people.clear(); });
  EXPECT_EQ(rate({{"rating", 1}}), ProblemKind::kParticipationEnded);
}

TEST_F(ParticipationTest, ASessionEndsIfTheStudyClosesDuringItsPlacement) {
  ASSERT_TRUE(join(key));
  placement.before("place", [&] { store.open = false; });
  EXPECT_EQ(refusal(participations.visit(key, "look")), ProblemKind::kStudyClosed);
  EXPECT_TRUE(placement.sessions.empty());
}

TEST_F(ParticipationTest, AScanSharedWithTheResearcherIsNotShownToParticipants) {
  store.study.owner_id = shared.user_id;
  ASSERT_TRUE(join(key));
  EXPECT_EQ(refusal(participations.visit(key, "look")), ProblemKind::kForbidden);
  expose(Exposure::kPublic);
  EXPECT_TRUE(participations.visit(key, "look"));
}

TEST_F(ParticipationTest, RecordsOnlyWhoAgreed) {
  ASSERT_TRUE(join(key));
  ASSERT_TRUE(join(other, true));
  EXPECT_EQ(refusal(participations.record(key, "look", "{}")), ProblemKind::kForbidden);
  EXPECT_EQ(refusal(participations.record(other, "look", "{}")), Refusal());
  EXPECT_EQ(store.calls("add_recording"), 1);
}

TEST_F(ParticipationTest, WithdrawalEndsTheSessionAndCanBeRepeated) {
  ASSERT_TRUE(join(key));
  const auto opened = participations.visit(key, "look");
  store.open = false;
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(participations.withdraw(key));
  EXPECT_TRUE(store.people.empty());
  EXPECT_TRUE(placement.sessions.empty());
}

TEST_F(ParticipationTest, AnUnavailableStoreIsReported) {
  ASSERT_TRUE(join(key));
  expect_unavailable(
      {{store, "find",
        [&] {
          return rate({{"rating", 1}});
        }},
       {store, "answer",
        [&] {
          return rate({{"rating", 1}});
        }},
       {store, "invitation", [&] { return refusal(join(other)); }},
       {store, "join", [&] { return refusal(join(other)); }},
       {store, "finish", [&] { return refusal(participations.finish(key)); }},
       {store, "note_session", [&] { return refusal(participations.visit(key, "look")); }},
       {store, "withdraw", [&] { return refusal(participations.withdraw(key)); }}});
}

}  // namespace
}  // namespace diaphane::api
