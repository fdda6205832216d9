#include "api/stream/worker_channels.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <new>
#include <thread>
#include <utility>
#include <vector>

#include "common/fd.h"
#include "common/wire/grpc_credentials.h"

namespace diaphane::api::stream {
namespace {

// A frame of 4096 x 4096 in one message, with room.
constexpr int kMostMessageBytes = 64 << 20;

class Socket {
 public:
  explicit Socket(const addrinfo& info)
      : fd_(::socket(info.ai_family, info.ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC,
                     info.ai_protocol)) {}

  bool connects(const addrinfo& info, std::chrono::milliseconds timeout) const {
    if (!fd_) return false;
    if (::connect(fd_.get(), info.ai_addr, info.ai_addrlen) == 0) return true;
    if (errno != EINPROGRESS) return false;
    pollfd waiting{fd_.get(), POLLOUT, 0};
    if (::poll(&waiting, 1, static_cast<int>(timeout.count())) != 1) return false;
    int error = 0;
    socklen_t size = sizeof error;
    return ::getsockopt(fd_.get(), SOL_SOCKET, SO_ERROR, &error, &size) == 0 && error == 0;
  }

 private:
  Fd fd_;
};

}  // namespace

WorkerChannels::WorkerChannels(wire::InnerTls tls)
    : tls_(std::move(tls)), credentials_(wire::channel_credentials(tls_)) {}

std::shared_ptr<grpc::Channel> WorkerChannels::to(const std::string& address,
                                                  const std::string& incarnation) {
  const std::lock_guard lock(mutex_);
  std::shared_ptr<grpc::Channel>& channel = channels_[address + "|" + incarnation];
  if (!channel) {
    grpc::ChannelArguments arguments;
    arguments.SetMaxReceiveMessageSize(kMostMessageBytes);
    // Not shared with another incarnation's channel, nor through a proxy of the environment.
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
    arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
    arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 1000);
    arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2000);
    // A worker that beats but answers nothing, or a line that swallows all: the calls end after 10
    // s.
    arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 5000);
    arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5000);
    arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
    channel = wire::open_channel(address, tls_, credentials_, arguments);
  }
  return channel;
}

void WorkerChannels::drop_unused() {
  std::vector<std::shared_ptr<grpc::Channel>> dropped;  // declared first: ended after the lock
  const std::lock_guard lock(mutex_);
  std::erase_if(channels_, [&](const auto& entry) {
    // Under the lock nobody can get it who has not got it already.
    if (entry.second.use_count() > 1) return false;
    dropped.push_back(entry.second);
    return true;
  });
}

WorkerChannels::~WorkerChannels() {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(2);
  for (drop_unused(); !channels_.empty(); drop_unused()) {
    if (std::chrono::steady_clock::now() > deadline) {
      // Better never ended than ended on a wrong thread; the process stops anyway.
      new (std::nothrow) auto(std::move(channels_));
      return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

bool accepts_connections(const std::string& address, std::chrono::milliseconds timeout) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos) return false;
  std::string host = address.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(host.c_str(), address.c_str() + colon + 1, &wanted, &found) != 0) return false;
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    if (Socket(*one).connects(*one, left)) return true;
  }
  return false;
}

}  // namespace diaphane::api::stream
