#include "bench/renderer/process_wire.h"

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>

#include "common/fd.h"

namespace diaphane::render::bench {
namespace {

struct Head {
  ProcessMessageKind word;
  std::uint64_t bytes;
};

/// Returns false, without a signal, if the other end has closed the socket.
bool send_all(int descriptor, const char* data, std::size_t bytes) {
  while (bytes > 0) {
    const ssize_t n = ::send(descriptor, data, bytes, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    data += n;
    bytes -= static_cast<std::size_t>(n);
  }
  return true;
}

}  // namespace

ProcessWire::~ProcessWire() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

bool ProcessWire::send(ProcessMessageKind word, std::string_view payload) const {
  const std::string head = packed(Head{word, payload.size()});
  return send_all(descriptor_, head.data(), head.size()) &&
         send_all(descriptor_, payload.data(), payload.size());
}

std::optional<ProcessMessage> ProcessWire::receive() const {
  Head head{};
  if (!read_all(descriptor_, reinterpret_cast<char*>(&head), sizeof head)) return std::nullopt;
  ProcessMessage message{head.word, std::string(head.bytes, '\0')};
  if (!read_all(descriptor_, message.payload.data(), head.bytes)) return std::nullopt;
  return message;
}

}  // namespace diaphane::render::bench
