#include "ingest/pipeline/clamd.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <numeric>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "common/connect.h"

namespace diaphane::ingest {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::size_t kTarBlock = 512;
constexpr milliseconds kStep{100};
constexpr milliseconds kConnecting{2000};

/// Parses a number of a tar header in octal digits.
std::optional<std::uint64_t> octal(std::span<const char> field) {
  std::uint64_t value = 0;
  bool any = false;
  for (const char c : field) {
    if (c == ' ' && !any) continue;
    if (c == ' ' || c == '\0') break;
    if (c < '0' || c > '7') return std::nullopt;
    value = value * 8 + static_cast<std::uint64_t>(c - '0');
    any = true;
  }
  if (!any) return std::nullopt;
  return value;
}

/// Returns the length of the content if `header` is a tar header (POSIX.1-2001, ustar).
std::optional<std::uint64_t> content_bytes(std::span<const char> header) {
  if (header.size() != kTarBlock) return std::nullopt;
  const auto sum_field = header.subspan(148, 8);
  const auto byte = [](std::uint64_t sum, char c) { return sum + static_cast<unsigned char>(c); };
  std::uint64_t sum = std::accumulate(header.begin(), header.end(), std::uint64_t{0}, byte);
  sum -= std::accumulate(sum_field.begin(), sum_field.end(), std::uint64_t{0}, byte);
  sum += sum_field.size() * std::uint64_t{' '};
  if (octal(sum_field) != sum) return std::nullopt;
  return octal(header.subspan(124, 12));
}

Fd connect_to(const std::string& address) {
  const bool path = address.starts_with('/') || address.find(':') == std::string::npos;
  return path ? connect_unix(address) : connect_tcp(address, kConnecting);
}

enum class Step { kDone, kStopped, kSilent, kBroken };

/// One conversation with clamd.
class Talk {
 public:
  Talk(Fd socket, milliseconds silence, const Clamd::ShouldContinue& should_continue)
      : socket_(std::move(socket)), silence_(silence), should_continue_(should_continue) {}

  Step send(std::string_view data) {
    while (!data.empty()) {
      const ssize_t sent = ::send(socket_.get(), data.data(), data.size(), MSG_NOSIGNAL);
      if (sent > 0) {
        last_reply_ = Clock::now();
        data.remove_prefix(static_cast<std::size_t>(sent));
        continue;
      }
      if (errno != EAGAIN && errno != EINTR) return Step::kBroken;
      if (const Step waited = wait_for(POLLOUT); waited != Step::kDone) return waited;
    }
    return Step::kDone;
  }

  /// Reads up to the terminating zero byte.
  Step receive(std::string& answer) {
    constexpr std::size_t kLongest = 4096;
    std::array<char, 512> some{};
    while (answer.empty() || answer.back() != '\0') {
      const ssize_t got = recv(socket_.get(), some.data(), some.size(), 0);
      if (got > 0) {
        last_reply_ = Clock::now();
        answer.append(some.data(), static_cast<std::size_t>(got));
        if (answer.size() > kLongest) return Step::kBroken;
        continue;
      }
      if (got == 0 || (errno != EAGAIN && errno != EINTR)) return Step::kBroken;
      if (const Step waited = wait_for(POLLIN); waited != Step::kDone) return waited;
    }
    answer.pop_back();
    return Step::kDone;
  }

 private:
  Step wait_for(short what) {
    for (;;) {
      pollfd one{socket_.get(), what, 0};
      if (poll(&one, 1, static_cast<int>(kStep.count())) > 0) return Step::kDone;
      if (!should_continue_()) return Step::kStopped;
      if (Clock::now() - last_reply_ > silence_) return Step::kSilent;
    }
  }

  Fd socket_;
  const milliseconds silence_;
  const Clamd::ShouldContinue& should_continue_;
  Clock::time_point last_reply_ = Clock::now();
};

std::string length_word(std::uint32_t bytes) {
  const std::uint32_t big_endian = htonl(bytes);
  std::string word(sizeof big_endian, '\0');
  std::memcpy(word.data(), &big_endian, sizeof big_endian);
  return word;
}

/// Sends `piece` with INSTREAM. Also returns kBroken if clamd ends the stream early, after which
/// its answer is available.
Step stream(Talk& talk, int fd, const Piece& piece, std::string& buffer) {
  constexpr std::string_view kCommand("zINSTREAM\0", 10);
  Step step = talk.send(kCommand);
  for (std::uint64_t at = 0; step == Step::kDone && at < piece.bytes;) {
    const auto part = std::min<std::uint64_t>(piece.bytes - at, 1 << 18);
    buffer = length_word(static_cast<std::uint32_t>(part));
    buffer.resize(buffer.size() + part);
    const ssize_t got = pread(fd, buffer.data() + 4, part, static_cast<off_t>(piece.offset + at));
    if (got != static_cast<ssize_t>(part)) return Step::kBroken;
    step = talk.send(buffer);
    at += part;
  }
  return step == Step::kDone ? talk.send(length_word(0)) : step;
}

std::string words_of(int error) { return std::string("clamd: ") + std::strerror(error); }

}  // namespace

Piece piece_at(std::uint64_t at, std::span<const char> header, std::uint64_t end) {
  const auto bytes = content_bytes(header);
  const std::uint64_t begin = at + kTarBlock;
  if (!bytes || begin > end || *bytes > end - begin) return {at, end - at, end};
  const std::uint64_t padded = (*bytes + kTarBlock - 1) / kTarBlock * kTarBlock;
  return {begin, *bytes, begin + std::min(padded, end - begin)};
}

Result<Clamd::Found> Clamd::look_at(int fd, const ShouldContinue& should_continue) const {
  struct stat info {};
  if (fstat(fd, &info) != 0) return fail(ErrorCode::kInternal, "cannot read the upload");
  const auto end = static_cast<std::uint64_t>(info.st_size);
  std::array<char, kTarBlock> header{};
  for (std::uint64_t at = 0; at < end;) {
    const ssize_t got = pread(fd, header.data(), header.size(), static_cast<off_t>(at));
    if (got <= 0) return fail(ErrorCode::kInternal, "cannot read the upload");
    const Piece piece = piece_at(at, {header.data(), static_cast<std::size_t>(got)}, end);
    for (std::uint64_t done = 0; done < piece.bytes;) {
      const std::uint64_t bytes = std::min(piece.bytes - done, options_.most_bytes);
      auto found = look_at(fd, {piece.offset + done, bytes, 0}, should_continue);
      if (!found || *found != Found::kClean) return found;
      done += bytes;
      if (done < piece.bytes) done -= std::min(kOverlap, bytes / 2);
    }
    at = piece.next;
  }
  return Found::kClean;
}

Result<Clamd::Found> Clamd::look_at(int fd, const Piece& piece,
                                    const ShouldContinue& should_continue) const {
  std::string buffer;
  // clamd may be starting or loading new signatures.
  for (const auto until = Clock::now() + options_.silence;;) {
    if (!should_continue()) return Found::kStopped;
    std::string why;
    if (Fd socket = connect_to(options_.address)) {
      Talk talk(std::move(socket), options_.silence, should_continue);
      Step step = stream(talk, fd, piece, buffer);
      std::string answer;
      if (step == Step::kDone || step == Step::kBroken) step = talk.receive(answer);
      if (step == Step::kStopped) return Found::kStopped;
      if (step == Step::kSilent) return fail(ErrorCode::kUnavailable, "clamd does not respond");
      if (step == Step::kDone) {
        if (answer == "stream: OK") return Found::kClean;
        if (answer.ends_with(" FOUND")) return Found::kInfected;
        return fail(ErrorCode::kUnavailable, "clamd: " + answer);
      }
      why = "clamd closed the connection";
    } else {
      why = words_of(errno);
    }
    if (Clock::now() >= until) return fail(ErrorCode::kUnavailable, why);
    std::this_thread::sleep_for(kStep);
  }
}

}  // namespace diaphane::ingest
