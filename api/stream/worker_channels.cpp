#include "api/stream/worker_channels.h"

#include <new>
#include <thread>
#include <utility>
#include <vector>

#include "common/connect.h"
#include "common/wire/grpc_credentials.h"

namespace diaphane::api::stream {
namespace {

// Large enough for a frame of 4096 x 4096 in one message.
constexpr int kMostMessageBytes = 64 << 20;

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
    // Channels are not shared between incarnations, and do not use a proxy from the environment.
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
    arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
    arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 1000);
    arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2000);
    // If a worker sends heartbeats but does not respond, or the network drops all packets, the
    // calls end after 10 s.
    arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 5000);
    arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5000);
    arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
    channel = wire::open_channel(address, tls_, credentials_, arguments);
  }
  return channel;
}

void WorkerChannels::drop_unused() {
  std::vector<std::shared_ptr<grpc::Channel>> dropped;  // destroyed after the lock is released
  const std::lock_guard lock(mutex_);
  std::erase_if(channels_, [&](const auto& entry) {
    // No other thread can obtain this channel while the lock is held.
    if (entry.second.use_count() > 1) return false;
    dropped.push_back(entry.second);
    return true;
  });
}

WorkerChannels::~WorkerChannels() {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(2);
  for (drop_unused(); !channels_.empty(); drop_unused()) {
    if (std::chrono::steady_clock::now() > deadline) {
      // A leak is better than destruction on the wrong thread, and the process is exiting anyway.
      new (std::nothrow) auto(std::move(channels_));
      return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

bool accepts_connections(const std::string& address, std::chrono::milliseconds timeout) {
  const std::string path = unix_path(address);
  return static_cast<bool>(path.empty() ? connect_tcp(address, timeout) : connect_unix(path));
}

}  // namespace diaphane::api::stream
