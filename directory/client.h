#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "common/wire/inner_tls.h"
#include "directory/reply.h"
#include "directory/script.h"

namespace diaphane::directory {

using Arguments = std::vector<std::string_view>;

/// Redis with a small connection pool. This is the only class that uses hiredis. Thread-safe. A
/// call blocks for at most `connect_timeout` + `command_timeout` + the wait for a connection
/// (`command_timeout` too). Broken connections are closed and the next call opens a new one, so
/// that a restarted Redis is used immediately.
///
/// All calls return kUnavailable if Redis is unreachable, too slow, loading, out of memory or a
/// replica, and kInternal if it rejects the command (a bug in Diaphane).
class Client {
 public:
  struct Options {
    std::string address;  ///< "host:port", "rediss://host:port" with TLS, or "unix:/path"
    std::size_t connections = 8;
    std::chrono::milliseconds connect_timeout{250};
    std::chrono::milliseconds command_timeout{1000};
    wire::InnerTls tls{};  ///< TLS settings for a rediss address, and whether plaintext is allowed
  };

  /// Creates a client, which connects on first use. Returns kInvalid if the address is malformed or
  /// requires TLS.
  static Result<std::unique_ptr<Client>> create(Options options);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Runs one command, such as {"GET", "key"}.
  Result<Reply> command(const Arguments& command_line);
  /// Runs EVALSHA without keys, or EVAL if Redis does not know the script, for example after a
  /// restart.
  Result<Reply> run(const Script& script, const Arguments& arguments);
  /// Returns whether Redis answers a PING within `timeout`.
  bool answers(std::chrono::milliseconds timeout);

 private:
  struct Impl;
  explicit Client(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::directory
