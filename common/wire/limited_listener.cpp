#include "common/wire/limited_listener.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstring>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "common/fd.h"
#include "common/log.h"

namespace diaphane::wire {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// The server's timer starts slightly after accept() and needs a moment to close the connection.
constexpr milliseconds kGrace{2'000};
/// Data that a peer does not acknowledge for this long ends the connection.
constexpr int kUserTimeoutMs = 5'000;
/// While no descriptor or memory is free, accepting pauses for this long.
constexpr milliseconds kPause{100};
constexpr std::chrono::seconds kBetweenWarnings{10};
constexpr milliseconds kBetweenSweeps{50};

ino_t inode_of(int socket) {
  struct stat state {};
  return ::fstat(socket, &state) == 0 ? state.st_ino : 0;
}

PeerAddress address_of(const sockaddr_storage& peer) {
  PeerAddress address{};
  if (peer.ss_family == AF_INET6) {
    std::memcpy(address.data(), &reinterpret_cast<const sockaddr_in6&>(peer).sin6_addr, 16);
  } else {
    address[10] = address[11] = 0xff;
    std::memcpy(address.data() + 12, &reinterpret_cast<const sockaddr_in&>(peer).sin_addr, 4);
  }
  return address;
}

void set(int socket, int level, int option, int value) {
  ::setsockopt(socket, level, option, &value, sizeof value);
}

Fd listen_on(const addrinfo& where, bool both_families) {
  Fd socket_fd(::socket(where.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket_fd) return socket_fd;
  set(socket_fd.get(), SOL_SOCKET, SO_REUSEADDR, 1);
  if (where.ai_family == AF_INET6) {
    set(socket_fd.get(), IPPROTO_IPV6, IPV6_V6ONLY, both_families ? 0 : 1);
  }
  // Accepted sockets inherit these.
  set(socket_fd.get(), IPPROTO_TCP, TCP_NODELAY, 1);
  set(socket_fd.get(), IPPROTO_TCP, TCP_USER_TIMEOUT, kUserTimeoutMs);
  if (::bind(socket_fd.get(), where.ai_addr, where.ai_addrlen) != 0 ||
      ::listen(socket_fd.get(), SOMAXCONN) != 0) {
    return Fd(-1);
  }
  return socket_fd;
}

Fd listen_on(std::string host, std::uint16_t port) {
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  const bool everywhere = host == "0.0.0.0" || host == "::";
  // A machine without IPv6 listens on IPv4 only.
  const std::vector<std::string> hosts =
      everywhere ? std::vector<std::string>{"::", "0.0.0.0"} : std::vector{host};
  for (const std::string& one : hosts) {
    addrinfo* found = nullptr;
    if (::getaddrinfo(one.c_str(), std::to_string(port).c_str(), &hints, &found) != 0) continue;
    const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
    for (const addrinfo* at = found; at != nullptr; at = at->ai_next) {
      if (Fd socket_fd = listen_on(*at, everywhere)) return socket_fd;
      if (errno == EADDRINUSE) return Fd(-1);
    }
  }
  return Fd(-1);
}

std::uint16_t port_of(int socket) {
  sockaddr_storage own{};
  socklen_t size = sizeof own;
  if (::getsockname(socket, reinterpret_cast<sockaddr*>(&own), &size) != 0) return 0;
  return ntohs(own.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(own).sin6_port
                                         : reinterpret_cast<const sockaddr_in&>(own).sin_port);
}

}  // namespace

std::optional<PeerAddress> parse_peer(const std::string& peer) {
  const std::size_t begin = peer.find(':'), end = peer.rfind(':');
  if (begin == std::string::npos || begin == end) return std::nullopt;
  const std::string family = peer.substr(0, begin);
  std::string host = peer.substr(begin + 1, end - begin - 1);
  PeerAddress address{};
  if (family == "ipv4") {
    host = "::ffff:" + host;
  } else if (family != "ipv6") {
    return std::nullopt;
  }
  if (host.starts_with("%5B") && host.ends_with("%5D")) host = host.substr(3, host.size() - 6);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  if (::inet_pton(AF_INET6, host.c_str(), address.data()) != 1) return std::nullopt;
  return address;
}

bool UnfinishedHandshakes::has_room_for(const PeerAddress& address, bool known) const {
  std::size_t all = 0, same = 0;
  for (const Connection& one : connections_) {
    if (one.known == known) ++all;
    if (one.address == address) ++same;
  }
  return all < limits_.total && same < limits_.per_address;
}

void UnfinishedHandshakes::know(const PeerAddress& address, TimePoint now) {
  known_[address] = now;
  if (known_.size() <= kMostKnown) return;
  known_.erase(std::min_element(known_.begin(), known_.end(),
                                [](const auto& a, const auto& b) { return a.second < b.second; }));
}

bool UnfinishedHandshakes::admit(const PeerAddress& address, int socket, TimePoint now) {
  while (!connections_.empty() && now - connections_.front().since > limits_.deadline + kGrace) {
    connections_.pop_front();
  }
  const bool known = known_.contains(address);
  // A flood must not make each refusal cost a system call per connection.
  if (!has_room_for(address, known) && now - swept_ >= kBetweenSweeps) {
    swept_ = now;
    // The server closes descriptors without notice, and another file may get the same number.
    std::erase_if(connections_,
                  [](const Connection& one) { return inode_of(one.socket) != one.inode; });
  }
  if (!has_room_for(address, known)) return false;
  connections_.push_back({address, socket, inode_of(socket), now, known});
  return true;
}

struct LimitedListener::Impl {
  Impl(Fd listening, UnfinishedHandshakes::Limits limits)
      : listener(std::move(listening)), port(port_of(listener->get())), unfinished(limits) {}

  void run(const std::function<void(int)>& take);
  void refuse(std::size_t count);

  std::optional<Fd> listener;  ///< empty after stop()
  Fd wake{::eventfd(0, EFD_CLOEXEC)};
  const std::uint16_t port;
  std::mutex mutex;
  UnfinishedHandshakes unfinished;  ///< under the mutex
  std::int64_t refused = 0;
  steady_clock::time_point warned{};
  std::thread thread;
};

void LimitedListener::Impl::refuse(std::size_t count) {
  ++refused;
  const auto now = steady_clock::now();
  if (now - warned < kBetweenWarnings) return;
  warned = now;
  log::warning("too_many_unfinished_handshakes",
               {{"refused", std::exchange(refused, 0)}, {"unfinished", count}});
}

void LimitedListener::Impl::run(const std::function<void(int)>& take) {
  while (true) {
    std::array<pollfd, 2> ready{pollfd{listener->get(), POLLIN, 0}, pollfd{wake.get(), POLLIN, 0}};
    if (::poll(ready.data(), ready.size(), -1) < 0 && errno != EINTR) return;
    if (ready[1].revents != 0) return;
    if (ready[0].revents == 0) continue;
    sockaddr_storage peer{};
    socklen_t size = sizeof peer;
    const int socket = ::accept4(listener->get(), reinterpret_cast<sockaddr*>(&peer), &size,
                                 SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) {
      if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) {
        std::this_thread::sleep_for(kPause);
      }
      continue;
    }
    std::unique_lock lock(mutex);
    const bool admitted = unfinished.admit(address_of(peer), socket, steady_clock::now());
    const std::size_t count = unfinished.count();
    lock.unlock();
    if (admitted) {
      take(socket);
    } else {
      ::close(socket);
      refuse(count);
    }
  }
}

Result<std::unique_ptr<LimitedListener>> LimitedListener::open(
    const std::string& host, std::uint16_t port, UnfinishedHandshakes::Limits limits) {
  Fd listening = listen_on(host, port);
  if (!listening) {
    return fail(ErrorCode::kUnavailable, "cannot listen on " + host + ":" + std::to_string(port));
  }
  return std::unique_ptr<LimitedListener>(
      new LimitedListener(std::make_unique<Impl>(std::move(listening), limits)));
}

LimitedListener::LimitedListener(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LimitedListener::~LimitedListener() { stop(); }

std::uint16_t LimitedListener::port() const { return impl_->port; }

void LimitedListener::start(std::function<void(int)> take) {
  impl_->thread = std::thread([impl = impl_.get(), take = std::move(take)] { impl->run(take); });
}

void LimitedListener::know(const std::string& peer) {
  const auto address = parse_peer(peer);
  if (!address) return;
  const std::lock_guard lock(impl_->mutex);
  impl_->unfinished.know(*address, steady_clock::now());
}

void LimitedListener::stop() {
  if (impl_->thread.joinable()) {
    const std::uint64_t one = 1;
    (void)write_all(impl_->wake.get(), &one, sizeof one);
    impl_->thread.join();
  }
  impl_->listener.reset();
}

}  // namespace diaphane::wire
