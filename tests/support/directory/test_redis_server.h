#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

#include "tests/support/common/claimed_port.h"

namespace diaphane::directory {

/// A real redis-server for one test, on a free loopback port and in its own directory.
class TestRedisServer {
 public:
  TestRedisServer();
  ~TestRedisServer();
  TestRedisServer(const TestRedisServer&) = delete;
  TestRedisServer& operator=(const TestRedisServer&) = delete;

  std::string address() const { return "127.0.0.1:" + std::to_string(port_.number()); }
  void start();  ///< on the same port as before; waits until it answers
  void kill();   ///< SIGKILL
  void pause();  ///< SIGSTOP: it accepts and never answers
  void resume();

 private:
  std::filesystem::path directory_;
  ClaimedPort port_;
  pid_t pid_ = -1;
};

}  // namespace diaphane::directory
