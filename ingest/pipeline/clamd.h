#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "common/result.h"

namespace diaphane::ingest {

/// What of a file is looked at by itself, and where the next such part begins.
struct Piece {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
  std::uint64_t next = 0;
};

/// The content of the tar entry whose header is at `at`, of a file of `end` bytes; what is no
/// header is one piece with all that follows, so that nothing is passed over that another reader
/// might see. `header`: up to 512 bytes from `at` on.
Piece piece_at(std::uint64_t at, std::span<const char> header, std::uint64_t end);

/// ClamAV's daemon, by its command INSTREAM (clamd(8)).
class Clamd {
 public:
  struct Options {
    std::string address;  ///< path of a Unix socket, or host:port
    /// It may be as long without a word (none listens, nothing is taken, no answer comes).
    std::chrono::milliseconds silence{30000};
    /// Of one stream: no more than clamd's own StreamMaxLength. Longer files are sent in parts that
    /// overlap by kOverlap.
    std::uint64_t most_bytes = std::uint64_t{25} << 20;
  };
  static constexpr std::uint64_t kOverlap = 65536;
  enum class Found { kClean, kInfected, kStopped };
  using GoOn = std::function<bool()>;

  explicit Clamd(Options options) : options_(std::move(options)) {}

  /// What it says of the contents of the tar behind `fd`; kStopped as soon as `go_on`, which is
  /// asked several times a second, says no. kUnavailable: it could not be asked, with the reason.
  Result<Found> look_at(int fd, const GoOn& go_on) const;

 private:
  Result<Found> look_at(int fd, const Piece& piece, const GoOn& go_on) const;
  Options options_;
};

}  // namespace diaphane::ingest
