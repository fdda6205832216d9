#pragma once

#include <sys/types.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "common/result.h"

namespace diaphane::wire {

/// An IP address without a port. IPv4 addresses are mapped into IPv6.
using PeerAddress = std::array<std::uint8_t, 16>;

/// Returns the address in gRPC's name of a peer, or nullopt for one without an IP address.
std::optional<PeerAddress> parse_peer(const std::string& peer);

/// Counts the connections whose handshake may be unfinished: those that are younger than the
/// deadline of the handshake and still open. The server that owns a connection closes it at the
/// deadline unless it is authenticated, so this count is an upper bound. Not thread-safe.
///
/// Addresses that have made an authenticated call are counted separately from all others, so that
/// strangers at many addresses cannot keep known clients from connecting.
class UnfinishedHandshakes {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  struct Limits {
    std::size_t total = 256;  ///< limit for known addresses, and again for others
    std::size_t per_address = 32;
    std::chrono::milliseconds deadline{10'000};
  };

  static constexpr std::size_t kMostKnown = 1024;

  explicit UnfinishedHandshakes(Limits limits) : limits_(limits) {}

  /// Returns whether a connection may be handed to the server, and counts it if so.
  bool admit(const PeerAddress& address, int socket, TimePoint now);
  /// Records an authenticated call from this address. Above `kMostKnown` addresses, forgets the one
  /// with the oldest call.
  void know(const PeerAddress& address, TimePoint now);
  std::size_t count() const { return connections_.size(); }

 private:
  struct Connection {
    PeerAddress address;
    int socket;
    ino_t inode;  ///< for detecting that the descriptor was closed and reused
    TimePoint since;
    bool known;
  };
  bool has_room_for(const PeerAddress& address, bool known) const;

  const Limits limits_;
  std::deque<Connection> connections_;  ///< the oldest first
  TimePoint swept_{};
  std::map<PeerAddress, TimePoint> known_;  ///< time of the last call by address
};

/// Listens on a TCP port and hands the connections to a server, but closes those that exceed the
/// limits. gRPC 1.51 itself limits unfinished handshakes only in time.
class LimitedListener {
 public:
  /// Opens the port. `host` is an address or a name, as in "host:port". 0.0.0.0 and [::] mean all
  /// addresses, including IPv6. Port 0 means any free port. Returns kUnavailable on failure.
  static Result<std::unique_ptr<LimitedListener>> open(const std::string& host, std::uint16_t port,
                                                       UnfinishedHandshakes::Limits limits);
  ~LimitedListener();

  std::uint16_t port() const;
  /// Starts a thread that accepts. `take` gets non-blocking sockets and closes them.
  void start(std::function<void(int socket)> take);
  /// Closes the port. Connections that were handed over stay open.
  void stop();
  /// Records an authenticated call from `peer`, in gRPC's form: "ipv4:1.2.3.4:5" or
  /// "ipv6:%5B::1%5D:5". Thread-safe.
  void know(const std::string& peer);

 private:
  struct Impl;
  explicit LimitedListener(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::wire
