#include "tests/support/directory/test_redis_server.h"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <stdexcept>
#include <thread>
#include <utility>

#include "directory/client.h"

namespace diaphane::directory {
namespace {

ClaimedPort claimed_port() {
  auto port = ClaimedPort::take();
  if (!port) throw std::runtime_error(port.error().message);
  return *std::move(port);
}

}  // namespace

TestRedisServer::TestRedisServer() : port_(claimed_port()) {
  ::signal(SIGPIPE, SIG_IGN);  // as common/service does in the programs
  char pattern[] = "/tmp/diaphane-redis-XXXXXX";
  if (::mkdtemp(pattern) == nullptr) throw std::runtime_error("no temporary directory");
  directory_ = pattern;
  start();
}

TestRedisServer::~TestRedisServer() {
  kill();
  std::error_code ignored;
  std::filesystem::remove_all(directory_, ignored);
}

void TestRedisServer::start() {
  const std::string port = std::to_string(port_.number());
  const pid_t test = ::getpid();
  pid_ = ::fork();
  if (pid_ == 0) {
    // The server ends when the test crashes, and closes the inherited pipes, which ctest reads
    // until their end.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != test) ::_exit(127);
    const int nothing = ::open("/dev/null", O_RDWR);
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nothing, stream);
    ::execlp("redis-server", "redis-server", "--port", port.c_str(), "--bind", "127.0.0.1",
             "--save", "", "--appendonly", "yes", "--dir", directory_.c_str(),
             static_cast<char*>(nullptr));
    ::_exit(127);
  }
  auto client = Client::create({.address = address()});
  for (int attempt = 0; attempt < 200; ++attempt) {
    if ((*client)->answers(std::chrono::milliseconds(100))) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  throw std::runtime_error("redis-server did not start");
}

void TestRedisServer::kill() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

void TestRedisServer::pause() { ::kill(pid_, SIGSTOP); }
void TestRedisServer::resume() { ::kill(pid_, SIGCONT); }

}  // namespace diaphane::directory
