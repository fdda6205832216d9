#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "common/result.h"
#include "common/wire/inner_tls.h"

namespace diaphane::wire {

/// TLS for a library that knows none (Debian 12's hiredis): a local socket whose other end is
/// carried over a TLS connection by one thread of this object's. Thread-safe.
class TlsTunnels {
 public:
  explicit TlsTunnels(TlsFiles files);
  /// Ends them all: whoever holds the other end of one reads the end of the stream.
  ~TlsTunnels();
  TlsTunnels(const TlsTunnels&) = delete;
  TlsTunnels& operator=(const TlsTunnels&) = delete;

  /// A connected stream socket, the caller's to close. The certificate of the other side must be
  /// signed by the CA, for `host` (a name or an address), and ours is shown to it. The files are
  /// read each time. kUnavailable when it could not be had within `timeout`, with the reason.
  Result<int> open(const std::string& host, int port, std::chrono::milliseconds timeout);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::wire
