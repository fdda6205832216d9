#include "tests/support/common/claimed_port.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstring>
#include <random>
#include <string>
#include <utility>

namespace diaphane {
namespace {

constexpr int kFirst = 15000, kLast = 29999, kAttempts = 2000;

bool bind_to(int descriptor, const void* address, socklen_t size) {
  return ::bind(descriptor, static_cast<const sockaddr*>(address), size) == 0;
}

/// Returns a socket that is bound to the mark of this port, or -1 if another process has claimed
/// it.
int mark_of(std::uint16_t port) {
  const int mark = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (mark < 0) return -1;
  const std::string name = "diaphane-port-" + std::to_string(port);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path + 1, name.data(), name.size());  // abstract: it begins with a zero
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  if (bind_to(mark, &address, size)) return mark;
  ::close(mark);
  return -1;
}

bool nobody_listens(std::uint16_t port) {
  for (const in_addr_t where : {INADDR_LOOPBACK, INADDR_ANY}) {
    const int probe = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (probe < 0) return false;
    const int yes = 1;
    ::setsockopt(probe, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(where);
    const bool bound = bind_to(probe, &address, sizeof address);
    ::close(probe);
    if (!bound) return false;
  }
  return true;
}

}  // namespace

Result<ClaimedPort> ClaimedPort::take() {
  std::random_device random;
  std::uniform_int_distribution<int> any(kFirst, kLast);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const auto port = static_cast<std::uint16_t>(any(random));
    const int mark = mark_of(port);
    if (mark < 0) continue;
    ClaimedPort claimed(port, mark);
    if (nobody_listens(port)) return claimed;
  }
  return fail(ErrorCode::kUnavailable, "no free port found");
}

ClaimedPort::ClaimedPort(ClaimedPort&& other) noexcept
    : number_(other.number_), mark_(std::exchange(other.mark_, -1)) {}

ClaimedPort& ClaimedPort::operator=(ClaimedPort&& other) noexcept {
  std::swap(number_, other.number_);
  std::swap(mark_, other.mark_);
  return *this;
}

ClaimedPort::~ClaimedPort() {
  if (mark_ >= 0) ::close(mark_);
}

}  // namespace diaphane
