#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "directory/client.h"
#include "tests/support/common/claimed_port.h"
#include "tests/support/renderd/eventually.h"

namespace diaphane::render {

/// A redis-server for one test.
class TestRedis {
 public:
  TestRedis() { start(); }
  ~TestRedis() { stop(); }

  void start() {
    pid_ = fork();
    if (pid_ == 0) {
      const std::string number = std::to_string(port.number());
      execlp("redis-server", "redis-server", "--port", number.c_str(), "--bind", "127.0.0.1",
             "--save", "", "--appendonly", "no", "--logfile", "/dev/null", "--dir", "/tmp",
             nullptr);
      _exit(127);
    }
    EXPECT_TRUE(eventually([this] { return client().answers(std::chrono::seconds(1)); }))
        << "redis-server did not start";
  }
  void stop() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }
  directory::Client& client() { return *client_; }
  std::vector<std::string> ask(const std::vector<std::string>& words) {
    const auto reply = client().command({words.begin(), words.end()});
    if (!reply) return {};
    if (reply->kind == directory::Reply::Kind::kText) return {reply->text};
    std::vector<std::string> all;
    for (const directory::Reply& one : reply->list) all.push_back(one.text);
    return all;
  }
  std::int64_t number(const std::vector<std::string>& words) {
    const auto reply = client().command({words.begin(), words.end()});
    return reply ? reply->integer : -1;
  }
  std::string field(const std::string& key, const std::string& name) {
    const auto answer = ask({"HGET", key, name});
    return answer.empty() ? "" : answer.front();
  }

  const ClaimedPort port = ClaimedPort::take().value();

 private:
  const std::unique_ptr<directory::Client> client_ =
      directory::Client::create({.address = "127.0.0.1:" + std::to_string(port.number())}).value();
  pid_t pid_ = 0;
};

}  // namespace diaphane::render
