#include "common/connect.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <cstring>
#include <memory>

namespace diaphane {
namespace {

bool connects(int fd, const addrinfo& to, std::chrono::milliseconds timeout) {
  if (::connect(fd, to.ai_addr, to.ai_addrlen) == 0) return true;
  if (errno != EINPROGRESS) return false;
  pollfd waiting{fd, POLLOUT, 0};
  if (::poll(&waiting, 1, static_cast<int>(timeout.count())) != 1) {
    errno = ETIMEDOUT;
    return false;
  }
  int error = 0;
  socklen_t size = sizeof error;
  if (::getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size) != 0) return false;
  errno = error;
  return error == 0;
}

}  // namespace

Fd connect_tcp(const std::string& address, std::chrono::milliseconds timeout) {
  errno = EHOSTUNREACH;
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos) return Fd(-1);
  std::string host = address.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(host.c_str(), address.c_str() + colon + 1, &hints, &found) != 0) {
    errno = EHOSTUNREACH;
    return Fd(-1);
  }
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  int why = EHOSTUNREACH;
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0) break;
    Fd connection(::socket(one->ai_family, one->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC,
                           one->ai_protocol));
    if (connection && connects(connection.get(), *one, left)) return connection;
    why = errno;
  }
  errno = why;
  return Fd(-1);
}

std::string unix_path(std::string_view address) {
  constexpr std::string_view kScheme = "unix:";
  return address.starts_with(kScheme) ? std::string(address.substr(kScheme.size())) : "";
}

Fd connect_unix(const std::string& path) {
  sockaddr_un address{};
  static_assert(sizeof address.sun_path == kMostUnixPath + 1);
  address.sun_family = AF_UNIX;
  if (path.size() > kMostUnixPath) {
    errno = ENAMETOOLONG;
    return Fd(-1);
  }
  std::memcpy(address.sun_path, path.data(), path.size());
  Fd connection(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (connection && ::connect(connection.get(), reinterpret_cast<const sockaddr*>(&address),
                              sizeof address) != 0) {
    return Fd(-1);
  }
  return connection;
}

}  // namespace diaphane
