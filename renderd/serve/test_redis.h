#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "common/claimed_port.h"
#include "renderd/schedule/eventually.h"
#include "renderd/serve/redis_client.h"

namespace diaphane::render {

/// A redis-server of the test's own.
class TestRedis {
 public:
  TestRedis() { start(); }
  ~TestRedis() { stop(); }

  void start() {
    pid_ = fork();
    if (pid_ == 0) {
      const std::string port = std::to_string(address.port);
      execlp("redis-server", "redis-server", "--port", port.c_str(), "--bind", "127.0.0.1",
             "--save", "", "--appendonly", "no", "--logfile", "/dev/null", "--dir", "/tmp",
             nullptr);
      _exit(127);
    }
    EXPECT_TRUE(eventually([this] { return RedisClient(address).command({"PING"}).has_value(); }))
        << "redis-server did not start";
  }
  void stop() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }
  std::vector<std::string> ask(const std::vector<std::string>& words) {
    const auto answer = RedisClient(address).command(words);
    return answer ? answer->list : std::vector<std::string>{};
  }
  std::int64_t number(const std::vector<std::string>& words) {
    const auto answer = RedisClient(address).command(words);
    return answer ? answer->number : -1;
  }
  std::string field(const std::string& key, const std::string& name) {
    const auto answer = ask({"HGET", key, name});
    return answer.empty() ? "" : answer.front();
  }

  const ClaimedPort port = ClaimedPort::take().value();
  const wire::RedisAddress address{.host = "127.0.0.1", .port = port.number()};

 private:
  pid_t pid_ = 0;
};

}  // namespace diaphane::render
