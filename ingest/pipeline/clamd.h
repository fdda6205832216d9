#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "common/result.h"

namespace diaphane::ingest {

/// A part of a file that is scanned by itself, and where the next part begins.
struct Piece {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
  std::uint64_t next = 0;
};

/// Returns the content of the tar entry whose header is at `at` in a file of `end` bytes. Without a
/// valid header, the piece contains everything that follows, so that nothing is skipped that
/// another reader might see. `header` holds up to 512 bytes from `at`.
Piece piece_at(std::uint64_t at, std::span<const char> header, std::uint64_t end);

/// A client of ClamAV's daemon that uses its command INSTREAM (clamd(8)).
class Clamd {
 public:
  struct Options {
    std::string address;  ///< path of a Unix socket, or host:port
    /// Maximum time without a response (no listener, no progress in sending, no answer).
    std::chrono::milliseconds silence{30000};
    /// Maximum size of one stream, which must not exceed clamd's own StreamMaxLength. Longer files
    /// are sent in parts that overlap by kOverlap.
    std::uint64_t most_bytes = std::uint64_t{25} << 20;
  };
  static constexpr std::uint64_t kOverlap = 65536;
  enum class Found { kClean, kInfected, kStopped };
  using ShouldContinue = std::function<bool()>;

  explicit Clamd(Options options) : options_(std::move(options)) {}

  /// Scans the contents of the tar behind `fd`. Returns kStopped as soon as `should_continue`,
  /// which is called several times per second, returns false. Returns kUnavailable with the reason
  /// if clamd cannot be used.
  Result<Found> look_at(int fd, const ShouldContinue& should_continue) const;

 private:
  Result<Found> look_at(int fd, const Piece& piece, const ShouldContinue& should_continue) const;
  Options options_;
};

}  // namespace diaphane::ingest
