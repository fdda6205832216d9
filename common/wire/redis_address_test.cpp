#include "common/wire/redis_address.h"

#include <gtest/gtest.h>

namespace diaphane::wire {
namespace {

TEST(RedisAddress, ParsesHostAndPort) {
  const auto plain = parse_redis_address("127.0.0.1:6379");
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->host, "127.0.0.1");
  EXPECT_EQ(plain->port, 6379);
  EXPECT_FALSE(plain->with_tls);
}

TEST(RedisAddress, SchemeSelectsTls) {
  const auto ciphered = parse_redis_address("rediss://redis.stores:65535");
  ASSERT_TRUE(ciphered);
  EXPECT_EQ(ciphered->host, "redis.stores");
  EXPECT_EQ(ciphered->port, 65535);
  EXPECT_TRUE(ciphered->with_tls);
}

TEST(RedisAddress, RemovesBracketsOfIpv6Addresses) {
  EXPECT_EQ(parse_redis_address("[::1]:6379")->host, "::1");
  EXPECT_EQ(parse_redis_address("rediss://[fd00::1]:6379")->host, "fd00::1");
}

TEST(RedisAddress, LimitsUnixSocketsToAbsolutePathsOf107Bytes) {
  const auto socket = parse_redis_address("unix:/run/diaphane/redis.sock");
  ASSERT_TRUE(socket);
  EXPECT_EQ(socket->path, "/run/diaphane/redis.sock");
  EXPECT_TRUE(socket->host.empty());
  EXPECT_FALSE(socket->with_tls);
  EXPECT_TRUE(parse_redis_address("unix:/" + std::string(106, 'x')));
  EXPECT_FALSE(parse_redis_address("unix:/" + std::string(107, 'x')));
  EXPECT_FALSE(parse_redis_address("unix:redis.sock"));
}

TEST(RedisAddress, RefusesMalformedAddresses) {
  for (const char* wrong : {"", "host", ":1", "host:", "host:0", "host:65536", "host:1x", "host:-1",
                            "unix:", "rediss://", "rediss://host", "rediss://:1"}) {
    EXPECT_FALSE(parse_redis_address(wrong)) << wrong;
  }
}

}  // namespace
}  // namespace diaphane::wire
