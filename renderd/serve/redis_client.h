#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "common/wire/redis_address.h"

namespace diaphane::render {

/// One connection to Redis, used by one thread. Connects when first needed and again after a
/// failure; every call ends within the timeouts. The only place that names hiredis.
class RedisClient {
 public:
  explicit RedisClient(wire::RedisAddress address);
  ~RedisClient();

  /// What a script answered: an integer, or a list of texts.
  struct Answer {
    std::int64_t number = 0;
    std::vector<std::string> list;
  };
  /// Runs a Lua script by its hash, and by its text where Redis does not have it yet.
  /// kUnavailable: Redis is away (the connection is closed and made anew by the next call).
  /// kInternal: the script failed.
  Result<Answer> run(std::string_view script, const std::vector<std::string>& keys,
                     const std::vector<std::string>& arguments);
  /// For tests and checks: any command.
  Result<Answer> command(const std::vector<std::string>& words);
  bool connected() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::render
