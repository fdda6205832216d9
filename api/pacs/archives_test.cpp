#include "api/pacs/archives.h"

#include <gtest/gtest.h>

#include "api/accounts/api_tokens.h"
#include "tests/support/api/refusals.h"

namespace diaphane::api {
namespace {

const std::string kStudy = "1.2.840.113619.2.55";

class FakeGateway final : public ArchiveGateway {
 public:
  bool installed() const override { return is_installed; }
  Result<Answer> send(const std::string& path, const std::string& body) override {
    sent.emplace_back(path, Archives::Json::parse(body));
    if (during) during();
    if (!answers) return fail(ErrorCode::kUnavailable, "away");
    if (path == "/archives") return Answer{200, R"({"items":[{"name":"main"}]})"};
    return answer;
  }
  bool is_installed = true, answers = true;
  Answer answer{200, R"({"items":[{"patient_name":"Doe^Jane"},{"patient_name":"Doe^John"}]})"};
  std::vector<std::pair<std::string, Archives::Json>> sent;
  std::function<void()> during;
};

class FakeStore final : public ArchiveStore {
 public:
  Result<void> note(const AuditEntry& entry, Time) override {
    if (!works) return fail(ErrorCode::kUnavailable, "away");
    entries.push_back(entry);
    return {};
  }
  Result<void> begin_fetch(const std::string& user_id, const std::string& token_hash, Time now,
                           Time expires_at, const AuditEntry& entry) override {
    if (!works) return fail(ErrorCode::kUnavailable, "away");
    user = user_id;
    hash = token_hash;
    life = expires_at - now;
    entries.push_back(entry);
    return {};
  }
  bool works = true;
  std::vector<AuditEntry> entries;
  std::string user, hash;
  Time::duration life{};
};

class ArchivesTest : public testing::Test {
 protected:
  ArchivesTest() { who.user_id = "00000000-0000-4000-8000-000000000001"; }
  /// Returns everything that the audit log got, as one text.
  std::string log() const {
    std::string text;
    for (const AuditEntry& one : store.entries) text += one.action + details_as_json(one.details);
    return text;
  }

  FakeGateway gateway;
  FakeStore store;
  ManualClock clock;
  const SealingKey key = SealingKey::of_hex(std::string(64, '1')).value();
  Archives archives{gateway, store, key, clock};
  Principal who;
};

TEST_F(ArchivesTest, RecordsASearchWithItsNumberOfResultsAndWithoutPatientData) {
  const auto found = archives.search(who, "main", {.patient_name = "Doe"});
  ASSERT_TRUE(found);
  EXPECT_EQ((*found)["items"][0]["patient_name"], "Doe^Jane");
  EXPECT_EQ(log(), R"(archive.searched{"archive":"main","results":2})");
}

TEST_F(ArchivesTest, ReturnsNothingThatItCannotRecord) {
  store.works = false;
  EXPECT_EQ(refusal(archives.search(who, "main", {.patient_name = "Doe"})),
            ProblemKind::kUnavailable);
  EXPECT_EQ(refusal(archives.fetch(who, "main", {kStudy, "1.2", ""})), ProblemKind::kUnavailable);
  for (const auto& [path, body] : gateway.sent) EXPECT_NE(path, "/fetch");
}

TEST_F(ArchivesTest, RecordsStudiesAsKeyedHashes) {
  ASSERT_TRUE(archives.series(who, "main", kStudy));
  ASSERT_TRUE(archives.receive(who, "stow", kStudy));
  EXPECT_EQ(log().find(kStudy), std::string::npos);
  EXPECT_EQ(store.entries[0].details[1], store.entries[1].details[1]) << "the same study";
  const SealingKey other = SealingKey::of_hex(std::string(64, '2')).value();
  Archives elsewhere{gateway, store, other, clock};
  ASSERT_TRUE(elsewhere.receive(who, "stow", kStudy));
  EXPECT_NE(store.entries[1].details[1], store.entries[2].details[1]) << "another key";
}

TEST_F(ArchivesTest, RecordsAFailedSearch) {
  gateway.answer = {502, R"({"error":"unreachable"})"};
  EXPECT_EQ(refusal(archives.search(who, "main", {.patient_name = "Doe"})),
            ProblemKind::kArchiveUnreachable);
  EXPECT_EQ(log(), R"(archive.searched{"archive":"main","failed":1})");
}

TEST_F(ArchivesTest, SaysWhatIsWrongWithAnArchive) {
  const std::map<std::string, ProblemKind> kinds{{"unreachable", ProblemKind::kArchiveUnreachable},
                                                 {"slow", ProblemKind::kArchiveUnreachable},
                                                 {"unauthorised", ProblemKind::kArchiveRefused},
                                                 {"faulty", ProblemKind::kArchiveFaulty},
                                                 {"not-found", ProblemKind::kNotFound},
                                                 {"busy", ProblemKind::kTooMany},
                                                 {"anything", ProblemKind::kUnavailable}};
  for (const auto& [kind, expected] : kinds) {
    gateway.answer = {500, R"({"error":")" + kind + R"("})"};
    EXPECT_EQ(refusal(archives.series(who, "main", kStudy)), expected) << kind;
  }
  gateway.answer = {200, "no JSON"};
  EXPECT_EQ(refusal(archives.series(who, "main", kStudy)), ProblemKind::kUnavailable);
  gateway.answers = false;
  EXPECT_EQ(refusal(archives.series(who, "main", kStudy)), ProblemKind::kUnavailable);
}

TEST_F(ArchivesTest, GivesAFetchATokenThatIsStoredOnlyAsItsHash) {
  gateway.answer = {200, R"({"id":"1"})"};
  ASSERT_TRUE(archives.fetch(who, "main", {kStudy, "1.2.3", "Head"}));
  const auto& [path, body] = gateway.sent.back();
  EXPECT_EQ(path, "/fetch");
  const std::string token = body["token"];
  EXPECT_EQ(blake2b(token), store.hash);
  EXPECT_EQ(store.user, who.user_id);
  EXPECT_EQ(store.life, Archives::kFetchLife);
  EXPECT_EQ(log().find("1.2.3"), std::string::npos);
}

TEST_F(ArchivesTest, RefusesAnUnknownArchiveWithoutAToken) {
  EXPECT_EQ(refusal(archives.fetch(who, "other", {kStudy, "1.2.3", ""})), ProblemKind::kNotFound);
  EXPECT_TRUE(store.hash.empty());
}

TEST_F(ArchivesTest, RefusesMoreSearchesThanItCanWaitFor) {
  std::vector<ProblemKind> refusals;
  int depth = 0;
  gateway.during = [&] {
    if (++depth > Archives::kMostSearches) return;
    const auto next = archives.series(who, "main", kStudy);
    if (!next) refusals.push_back(next.error().kind);
  };
  EXPECT_TRUE(archives.series(who, "main", kStudy));
  EXPECT_EQ(refusals, std::vector{ProblemKind::kTooMany});
}

TEST_F(ArchivesTest, HasNoArchivesWithoutAGateway) {
  gateway.is_installed = false;
  EXPECT_TRUE((*archives.list())["items"].empty());
  EXPECT_EQ(refusal(archives.search(who, "main", {.patient_name = "Doe"})), ProblemKind::kNotFound);
  EXPECT_TRUE(gateway.sent.empty());
}

}  // namespace
}  // namespace diaphane::api
