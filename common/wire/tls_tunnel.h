#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "common/result.h"
#include "common/wire/inner_tls.h"

namespace diaphane::wire {

/// Adds TLS to a library without TLS support (Debian 12's hiredis). The library gets a local
/// socket, and a thread of this object relays its other end over a TLS connection. Thread-safe.
class TlsTunnels {
 public:
  explicit TlsTunnels(TlsFiles files);
  /// Closes all tunnels. Readers of the local sockets then see the end of the stream.
  ~TlsTunnels();
  TlsTunnels(const TlsTunnels&) = delete;
  TlsTunnels& operator=(const TlsTunnels&) = delete;

  /// Returns a connected stream socket, which the caller must close. The server's certificate must
  /// be signed by the CA and issued for `host` (a name or an address). Sends our own certificate.
  /// Reads the files for each call. Returns kUnavailable with a reason on failure or timeout.
  Result<int> open(const std::string& host, int port, std::chrono::milliseconds timeout);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::wire
