// Errors, clients, the audit log, idempotency keys, files of pictures, cursors, secrets and
// periodic tasks.
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <stdexcept>
#include <thread>

#include "api/shared/audit.h"
#include "api/shared/client.h"
#include "api/shared/cursor.h"
#include "api/shared/idempotency.h"
#include "api/shared/periodic.h"
#include "api/shared/picture_file.h"
#include "api/shared/problem.h"
#include "api/shared/secrets.h"
#include "common/ids.h"
#include "tests/support/api/temporary_directory.h"

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

TEST(Client, NetworkKeepsOnlyTheStartOfAnAddress) {
  EXPECT_EQ(coarse_network("203.0.113.77"), "203.0.0.0/16");
  EXPECT_EQ(coarse_network("2001:db8:85a3:8d3:1319:8a2e:370:7348"), "2001:db8::/32");
  EXPECT_EQ(coarse_network("::ffff:203.0.113.77"), "203.0.0.0/16");
  EXPECT_EQ(coarse_network("::1"), "::/32");
  for (const char* none : {"", "local", "203.0.113", "203.0.113.77:80"}) {
    EXPECT_EQ(coarse_network(none), "") << none;
  }
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

}  // namespace
}  // namespace diaphane::api
