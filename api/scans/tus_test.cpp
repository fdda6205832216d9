#include "api/scans/tus.h"

#include <gtest/gtest.h>

namespace diaphane::api::tus {
namespace {

ProblemKind refusal(const UploadProgress& progress, const PartRequest& request) {
  const auto part = plan_part(progress, request);
  EXPECT_FALSE(part);
  return part ? ProblemKind::kInternal : part.error().kind;
}

TEST(Tus, CreationReadsLengthAndMetadata) {
  const auto plan = plan_creation(
      {.length = "1000", .metadata = "title SGVhZA==,is_confidential, filename YS50YXI="});
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->length, 1000);
  EXPECT_EQ(plan->metadata.find("title")->second, "Head");
  EXPECT_EQ(plan->metadata.find("is_confidential")->second, "");
  EXPECT_EQ(plan->metadata.size(), 3u);
}

TEST(Tus, CreationRefusesMissingLengthOrMalformedMetadata) {
  for (const char* length : {"", "0", "-1", "1e3", "99999999999999999999"}) {
    EXPECT_FALSE(plan_creation({.length = length, .metadata = {}})) << length;
  }
  for (const char* metadata : {",", "title !", "title SGVhZA", "a YQ==,a YQ==", ",a YQ=="}) {
    EXPECT_FALSE(plan_creation({.length = "1", .metadata = metadata})) << metadata;
  }
}

TEST(Tus, AcceptsPartOnlyAtCurrentOffset) {
  const UploadProgress progress{.length = 100, .received = 40};
  for (int offset = 0; offset <= 110; ++offset) {
    const std::string text = std::to_string(offset);
    const auto part = plan_part(progress, {.offset = text, .bytes = 10});
    EXPECT_EQ(part.has_value(), offset == 40) << offset;
    if (!part) {
      EXPECT_EQ(part.error().kind, ProblemKind::kOffsetMismatch);
    }
  }
}

TEST(Tus, LastPartCompletesUploadAndNoPartExceedsItsLength) {
  const UploadProgress progress{.length = 100, .received = 40};
  EXPECT_FALSE(plan_part(progress, {.offset = "40", .bytes = 59})->completes);
  EXPECT_TRUE(plan_part(progress, {.offset = "40", .bytes = 60})->completes);
  EXPECT_EQ(refusal(progress, {.offset = "40", .bytes = 61}), ProblemKind::kInvalid);
}

TEST(Tus, EmptyPartAtTheEndMayBeRepeated) {
  const UploadProgress complete{.length = 100, .received = 100, .taken = true};
  EXPECT_TRUE(plan_part(complete, {.offset = "100", .bytes = 0}));
  EXPECT_EQ(refusal(complete, {.offset = "40", .bytes = 60}), ProblemKind::kUploadComplete);
  EXPECT_EQ(refusal(complete, {.offset = "100", .bytes = 1}), ProblemKind::kUploadComplete);
}

TEST(Tus, ExpiredUploadRefusesParts) {
  EXPECT_EQ(refusal({.length = 100, .received = 40, .expired = true}, {.offset = "40", .bytes = 1}),
            ProblemKind::kUploadExpired);
}

TEST(Tus, LimitsPartToEightMebibytes) {
  const UploadProgress progress{.length = 1 << 30};
  EXPECT_TRUE(plan_part(progress, {.offset = "0", .bytes = kMaxPartBytes}));
  EXPECT_EQ(refusal(progress, {.offset = "0", .bytes = kMaxPartBytes + 1}),
            ProblemKind::kBodyTooLarge);
}

TEST(Tus, MalformedOffsetNamesItsHeader) {
  for (const char* bad : {"", "-1", "+1", " 1", "1 ", "0x1", "99999999999999999999", "1.0"}) {
    const auto part = plan_part({.length = 10}, {.offset = bad, .bytes = 1});
    ASSERT_FALSE(part) << bad;
    EXPECT_EQ(part.error().fields.at(0).field, "Upload-Offset");
  }
}

TEST(Tus, ChecksumMatchesOnlyItsBytes) {
  // SHA-1 of "hello world", the example of tus 1.0.
  const auto sha1 = parse_checksum("sha1 Kq5sNclPz7QV2+lfQIuc6R7oRu0=");
  ASSERT_TRUE(sha1);
  EXPECT_TRUE(fits(*sha1, "hello world"));
  EXPECT_FALSE(fits(*sha1, "hello worle"));
  // SHA-256 of "abc" (FIPS 180-2).
  const auto sha256 = parse_checksum("sha256 ungWv48Bz+pBQUDeXa4iI7ADYaOWF3qctBD/YfIAFa0=");
  ASSERT_TRUE(sha256);
  EXPECT_TRUE(fits(*sha256, "abc"));
}

TEST(Tus, MalformedChecksumsAreRefused) {
  for (const char* bad :
       {"sha1", "sha1 ", "sha1 AAAA", "md5 rL0Y20zC+Fzt72VPzMSk2A==", "sha1 ????",
        "sha256 Kq5sNclPz7QV2+lfQIuc6R7oRu0=", "SHA1 Kq5sNclPz7QV2+lfQIuc6R7oRu0="}) {
    EXPECT_FALSE(parse_checksum(bad)) << bad;
  }
}

}  // namespace
}  // namespace diaphane::api::tus
