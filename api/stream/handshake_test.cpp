#include "api/stream/handshake.h"

#include <gtest/gtest.h>

namespace diaphane::api::stream {
namespace {

const std::string kTicket(64, 'a');
const std::string kTarget = "/stream?ticket=" + kTicket;
constexpr std::string_view kOrigin = "https://scans.example";

TEST(Handshake, ReturnsTicketForOwnOrigin) {
  EXPECT_EQ(*check_handshake({kTarget, kOrigin, "diaphane.v1"}, kOrigin), kTicket);
  EXPECT_EQ(*check_handshake({kTarget, kOrigin, "other, diaphane.v1 ,x"}, kOrigin), kTicket);
}

TEST(Handshake, RefusesEveryOtherOrigin) {
  for (const char* origin :
       {"", "null", "http://scans.example", "https://scans.example.evil.test", "https://evil.test",
        "https://scans.example:8443", "HTTPS://scans.example"}) {
    const auto result = check_handshake({kTarget, origin, "diaphane.v1"}, kOrigin);
    ASSERT_FALSE(result) << origin;
    EXPECT_EQ(result.error().code, ErrorCode::kForbidden) << origin;
  }
  EXPECT_FALSE(check_handshake({kTarget, "", "diaphane.v1"}, ""))
      << "no public origin admits nobody";
}

TEST(Handshake, RefusesInvalidTicketOrPath) {
  for (const std::string& target :
       {std::string(), std::string("/"), std::string("/stream"), std::string("/stream?ticket="),
        "/stream?ticket=" + std::string(63, 'a'), kTarget + "a", kTarget + "&x=1",
        "/stream?ticket=" + std::string(64, 'A'), "//stream?ticket=" + kTicket,
        "/stream/?ticket=" + kTicket, "/stream?ticket=" + std::string(64, '*')}) {
    const auto result = check_handshake({target, kOrigin, "diaphane.v1"}, kOrigin);
    ASSERT_FALSE(result) << target;
    EXPECT_EQ(result.error().code, ErrorCode::kInvalid) << target;
  }
}

TEST(Handshake, RefusesMissingSubprotocol) {
  for (const char* offered : {"", ",", "diaphane", "diaphane.v10", "diaphane.v1x, diaphane.v2"}) {
    EXPECT_FALSE(check_handshake({kTarget, kOrigin, offered}, kOrigin)) << offered;
  }
}

TEST(Handshake, SerializesOriginAsBrowsersDo) {
  EXPECT_EQ(origin_of("http://localhost:8080/"), "http://localhost:8080");
  EXPECT_EQ(origin_of("HTTPS://Scans.Example:443/x?y#z"), "https://scans.example");
  EXPECT_EQ(origin_of("http://scans.example:80"), "http://scans.example");
  EXPECT_EQ(origin_of("https://scans.example:80"), "https://scans.example:80");
  for (const char* none : {"", "localhost:8080", "ftp://x", "http://", "http:///x"}) {
    EXPECT_EQ(origin_of(none), "") << none;
  }
}

}  // namespace
}  // namespace diaphane::api::stream
