// Errors, limits, the audit log, cursors, secrets, mail retries and files of uploads.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>

#include "api/service/attempts.h"
#include "api/service/audit.h"
#include "api/service/cursor.h"
#include "api/service/housekeeping.h"
#include "api/service/idempotency.h"
#include "api/service/picture_file.h"
#include "api/service/secrets.h"
#include "api/service/temporary_directory.h"
#include "common/ids.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;

TEST(Problem, EachErrorOfAnAdapterHasItsKind) {
  for (const auto& [code, kind, wait] :
       {std::tuple(ErrorCode::kInvalid, ProblemKind::kInvalid, 0s),
        std::tuple(ErrorCode::kUnauthenticated, ProblemKind::kUnauthenticated, 0s),
        std::tuple(ErrorCode::kForbidden, ProblemKind::kForbidden, 0s),
        std::tuple(ErrorCode::kNotFound, ProblemKind::kNotFound, 0s),
        std::tuple(ErrorCode::kConflict, ProblemKind::kConflict, 0s),
        std::tuple(ErrorCode::kTooLarge, ProblemKind::kOverQuota, 0s),
        std::tuple(ErrorCode::kTooMany, ProblemKind::kTooMany, 10s),
        std::tuple(ErrorCode::kUnsupported, ProblemKind::kInvalid, 0s),
        std::tuple(ErrorCode::kUnavailable, ProblemKind::kUnavailable, 2s),
        std::tuple(ErrorCode::kOutOfMemory, ProblemKind::kUnavailable, 2s),
        std::tuple(ErrorCode::kDeviceLost, ProblemKind::kUnavailable, 2s),
        std::tuple(ErrorCode::kOutcomeUnknown, ProblemKind::kOutcomeUnknown, 2s),
        std::tuple(ErrorCode::kInternal, ProblemKind::kInternal, 0s)}) {
    const Problem problem = from_error({code, "detail", "field"});
    EXPECT_EQ(problem.kind, kind);
    EXPECT_EQ(problem.retry_after, wait);
    ASSERT_EQ(problem.fields.size(), 1u);
    EXPECT_EQ(problem.fields[0].field, "field");
    EXPECT_EQ(problem.detail == "detail", code != ErrorCode::kInternal)
        << "the reason of a bug is for the log only";
    EXPECT_TRUE(from_error({code, "detail", ""}).fields.empty());
  }
}

TEST(Attempts, RefusalStatesWaitInWholeMinutes) {
  for (const auto& [wait, words, retry] :
       {std::tuple(0s, "in 1 minute.", 1s), std::tuple(1s, "in 1 minute.", 1s),
        std::tuple(60s, "in 1 minute.", 60s), std::tuple(61s, "in 2 minutes.", 61s),
        std::tuple(900s, "in 15 minutes.", 900s)}) {
    const Problem refused = too_many_attempts(wait).value();
    EXPECT_EQ(refused.kind, ProblemKind::kTooManyAttempts);
    EXPECT_NE(refused.detail.find(words), std::string::npos) << refused.detail;
    EXPECT_EQ(refused.retry_after, retry);
  }
}

TEST(Attempts, AreCountedByKindAndSource) {
  const std::string key = attempt_key("account", "a@b");
  EXPECT_EQ(attempt_key("account", "a@b"), key);
  EXPECT_NE(attempt_key("address", "a@b"), key);
  EXPECT_NE(attempt_key("account", "a@c"), key);
  EXPECT_EQ(key.find("a@b"), std::string::npos);
}

TEST(Audit, DetailsAllowOnlyNumbersAndCodeWords) {
  EXPECT_EQ(details_as_json({}), "{}");
  EXPECT_EQ(details_as_json({{"items", std::int64_t{-3}}, {"reason", "not_theirs"}}),
            R"({"items":-3,"reason":"not_theirs"})");
  EXPECT_NO_THROW(details_as_json({{"word", std::string(40, 'a')}}));
  for (const std::string& bad : {std::string(), std::string(41, 'a'), std::string("Anna"),
                                 std::string("a@b"), std::string("a b"), std::string("a\"b")}) {
    EXPECT_THROW(details_as_json({{"word", bad}}), std::logic_error) << bad;
    EXPECT_THROW(details_as_json({{bad, std::int64_t{1}}}), std::logic_error) << bad;
  }
}

TEST(Audit, ActorsHaveNames) {
  EXPECT_EQ(to_string(AuditActor::kPerson), "person");
  EXPECT_EQ(to_string(AuditActor::kAdministrator), "administrator");
  EXPECT_EQ(to_string(AuditActor::kMachine), "machine");
}

TEST(Idempotency, TokenDependsOnKeyBrowserAndPurpose) {
  const std::string token = token_for("link", {"key", "browser"});
  EXPECT_TRUE(is_token(token));
  EXPECT_EQ(token_for("link", {"key", "browser"}), token);
  EXPECT_NE(token_for("other link", {"key", "browser"}), token);
  EXPECT_NE(token_for("link", {"other key", "browser"}), token);
  EXPECT_NE(token_for("link", {"key", "other browser"}), token);
  for (const IdempotencyScope& random :
       {IdempotencyScope{"", "browser"}, IdempotencyScope{"key", ""}, IdempotencyScope{}}) {
    EXPECT_TRUE(is_token(token_for("link", random)));
    EXPECT_NE(token_for("link", random), token_for("link", random));
  }
}

TEST(PictureFile, ReplacesFileAtomicallyWithoutLeftovers) {
  const TemporaryDirectory directory;
  ASSERT_TRUE(write_picture(directory.path() + "/a/b.jpg", "first"));
  ASSERT_TRUE(write_picture(directory.path() + "/a/b.jpg", "second"));
  EXPECT_EQ(directory.read("a/b.jpg"), "second");
  std::filesystem::create_directory(directory.path() + "/a/c.jpg");
  directory.write("a/c.jpg/file", "in the way");
  const auto refused = write_picture(directory.path() + "/a/c.jpg", "third");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnavailable);
  EXPECT_FALSE(write_picture(directory.path() + "/a/b.jpg/c.jpg", "fourth"));
  int entries = 0;
  for (const auto& one : std::filesystem::directory_iterator(directory.path() + "/a")) {
    (void)one;
    ++entries;
  }
  EXPECT_EQ(entries, 2) << "no temporary file is left";
}

TEST(Cursor, RoundTrips) {
  for (const std::int64_t us :
       {std::int64_t{0}, std::int64_t{1}, std::int64_t{1'700'000'000'123'456}}) {
    const Cursor cursor{us, new_id()};
    const auto decoded = decode_cursor(encode_cursor(cursor));
    ASSERT_TRUE(decoded);
    EXPECT_EQ(*decoded, cursor);
  }
}

TEST(Cursor, RefusesMalformedCursor) {
  const std::string good = encode_cursor({1234, new_id()});
  for (const std::string& bad :
       {std::string(), std::string("."), good.substr(1, 3), good + "0", "0" + good, "-" + good,
        std::string("1.' OR 1=1"), std::string("fffffffffffffff.") + new_id()}) {
    EXPECT_FALSE(decode_cursor(bad)) << bad;
  }
}

TEST(Secrets, Blake2bMatchesRfc7693) {
  // BLAKE2b (RFC 7693) with 256 bits, of an empty text.
  EXPECT_EQ(blake2b(""), "0e5751c026e543b2e8ab2eb06099daa1d1e5df47778f7787faab45cdf12fe3a8");
}

TEST(Secrets, IdFromTextIsDeterministic) {
  EXPECT_TRUE(is_id(id_from("something")));
  EXPECT_EQ(id_from("something"), id_from("something"));
  EXPECT_NE(id_from("something"), id_from("something else"));
}

TEST(Secrets, TokenHasSixtyFourLowerCaseHexDigits) {
  EXPECT_TRUE(is_token(random_hex(32)));
  EXPECT_FALSE(is_token(random_hex(31)));
  EXPECT_FALSE(is_token(std::string(64, 'A')));
  EXPECT_FALSE(equal_in_constant_time("a", "ab"));
  EXPECT_TRUE(equal_in_constant_time("ab", "ab"));
}

class Queue final : public MailStore {
 public:
  Result<std::optional<Queued>> claim_mail(Time now, std::chrono::seconds lease) override {
    if (done || not_before > now) return std::nullopt;
    not_before = now + lease;
    return Queued{1, attempts, {"a@b", "s", "b"}};
  }
  Result<void> mail_sent(std::int64_t) override {
    done = true;
    return {};
  }
  Result<void> mail_failed(std::int64_t, Time when) override {
    ++attempts;
    not_before = when;
    return {};
  }
  bool done = false;
  int attempts = 0;
  Time not_before;
};

class Transport final : public MailTransport {
 public:
  Result<void> send(const Mail&) override {
    ++calls;
    if (calls <= failures) return fail(code, "no");
    return {};
  }
  ErrorCode code = ErrorCode::kUnavailable;
  int failures = 0, calls = 0;
};

TEST(Mailer, RetriesWithBackoffUntilSent) {
  Queue queue;
  Transport transport;
  transport.failures = 3;
  ManualClock clock;
  Mailer mailer(queue, transport, clock);
  auto waited = 0s;
  while (!queue.done && waited < 1h) {
    mailer.send_due();
    clock.advance(1s);
    waited += 1s;
  }
  EXPECT_EQ(transport.calls, 4);
  EXPECT_GE(waited, 5s + 10s + 20s);
}

TEST(Mailer, GivesUpAfterPermanentErrorOrTooManyAttempts) {
  Queue refused_for_good, always_failing;
  Transport transport;
  transport.failures = 1000;
  ManualClock clock;
  transport.code = ErrorCode::kInvalid;
  Mailer(refused_for_good, transport, clock).send_due();
  EXPECT_TRUE(refused_for_good.done);
  transport.code = ErrorCode::kUnavailable;
  for (int i = 0; i < 12; ++i) {
    Mailer(always_failing, transport, clock).send_due();
    clock.advance(2h);
  }
  EXPECT_TRUE(always_failing.done);
}

TEST(Mailer, BackoffDoublesUpToOneHour) {
  EXPECT_EQ(Mailer::pause_after(1), 5s);
  EXPECT_EQ(Mailer::pause_after(2), 10s);
  EXPECT_EQ(Mailer::pause_after(100), 1h);
}

TEST(Periodic, ContinuesAfterExceptionAndKeepsWakeUps) {
  std::atomic<int> runs = 0;
  Periodic periodic("test", 1h, [&] {
    if (++runs == 1) throw std::runtime_error("once");
  });
  for (int i = 0; i < 400 && runs < 2; ++i) {
    periodic.wake();
    std::this_thread::sleep_for(5ms);
  }
  EXPECT_GE(runs, 2);
}

TEST(UploadFiles, AllowsOneWriterAndCreatesFileOnlyForFirstPart) {
  const auto directory = std::filesystem::temp_directory_path() / ("uploads-" + random_hex(8));
  std::filesystem::create_directories(directory);
  UploadFiles files(directory);
  const std::string id = new_id();
  EXPECT_FALSE(files.open(id, false));  // a later part creates no file
  {
    auto first = files.open(id, true);
    ASSERT_TRUE(first);
    const auto second = files.open(id, true);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, ErrorCode::kConflict);
    EXPECT_TRUE(first->write(3, "def"));
    EXPECT_TRUE(first->write(0, "abc"));
  }
  EXPECT_EQ(std::filesystem::file_size(directory / (id + ".tar")), 6u);
  EXPECT_TRUE(files.open(id, false));
  EXPECT_TRUE(files.remove(id));
  EXPECT_TRUE(files.remove(id));
  EXPECT_GT(files.free_bytes(), 0);
  std::filesystem::remove_all(directory);
}

TEST(UploadFiles, TruncatesPartialWriteOnFullDisk) {
  const auto directory = std::filesystem::temp_directory_path() / ("uploads-" + random_hex(8));
  std::filesystem::create_directories(directory);
  UploadFiles files(directory);
  const std::string id = new_id();
  // A file size limit simulates a full disk: the part is written up to the limit, and then the
  // write fails.
  struct rlimit before {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto ignored = ::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{1000, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  const auto written = [&] {
    auto file = files.open(id, true);
    EXPECT_TRUE(file && file->write(0, std::string(600, 'a')));
    return file->write(600, std::string(600, 'b'));
  }();
  ::setrlimit(RLIMIT_FSIZE, &before);
  ::signal(SIGXFSZ, ignored);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(std::filesystem::file_size(directory / (id + ".tar")), 600u);
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace diaphane::api
