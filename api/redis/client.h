#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "api/redis/reply.h"
#include "api/redis/script.h"
#include "common/result.h"
#include "common/wire/inner_tls.h"

namespace diaphane::api::redis {

using Arguments = std::vector<std::string_view>;

/// Redis behind a small pool of connections: the only place that names hiredis. Thread-safe; a call
/// blocks the calling thread for at most `connect_timeout` + `command_timeout` + the wait for a
/// connection
/// (`command_timeout` too). A broken connection is thrown away and the next call makes a new one,
/// so that a Redis that comes back is used at once.
///
/// Errors of every call: kUnavailable when Redis is away, too slow, loading, out of memory or a
/// replica; kInternal when it refuses the command (a defect of ours).
class Client {
 public:
  struct Options {
    std::string address;  ///< "host:port", "rediss://host:port" with TLS, or "unix:/path"
    std::size_t connections = 8;
    std::chrono::milliseconds connect_timeout{250};
    std::chrono::milliseconds command_timeout{1000};
    wire::InnerTls tls{};  ///< of a rediss address, and whether another may be plain
  };

  /// kInvalid for an address that is none, or that must not be plain. Connects only when it is
  /// used.
  static Result<std::unique_ptr<Client>> create(Options options);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  Result<Reply> command(const Arguments& words);
  /// EVALSHA without keys, EVAL when Redis does not know the script (it was restarted).
  Result<Reply> run(const Script& script, const Arguments& arguments);
  /// A PING answered within `timeout`.
  bool answers(std::chrono::milliseconds timeout);

 private:
  struct Impl;
  explicit Client(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace diaphane::api::redis
