#include "api/stream/handshake.h"

#include <algorithm>

namespace diaphane::api::stream {
namespace {

constexpr std::string_view kTargetStart = "/stream?ticket=";
constexpr std::size_t kTicketDigits = 64;

bool offers(std::string_view list, std::string_view protocol) {
  while (!list.empty()) {
    const std::size_t comma = list.find(',');
    std::string_view one = list.substr(0, comma);
    while (!one.empty() && (one.front() == ' ' || one.front() == '\t')) one.remove_prefix(1);
    while (!one.empty() && (one.back() == ' ' || one.back() == '\t')) one.remove_suffix(1);
    if (one == protocol) return true;
    if (comma == std::string_view::npos) break;
    list.remove_prefix(comma + 1);
  }
  return false;
}

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

}  // namespace

Result<std::string> check_handshake(const Handshake& handshake, std::string_view public_origin) {
  if (!handshake.target.starts_with(kTargetStart)) {
    return fail(ErrorCode::kInvalid, "This is not a stream URL.");
  }
  const std::string_view ticket = handshake.target.substr(kTargetStart.size());
  if (ticket.size() != kTicketDigits ||
      ticket.find_first_not_of("0123456789abcdef") != std::string_view::npos) {
    return fail(ErrorCode::kInvalid, "The ticket must be 64 hexadecimal digits.");
  }
  if (public_origin.empty() || handshake.origin != public_origin) {
    return fail(ErrorCode::kForbidden, "Streams are available only to pages of this origin.");
  }
  if (!offers(handshake.subprotocols, kSubprotocol)) {
    return fail(ErrorCode::kInvalid, "The client did not offer the subprotocol diaphane.v1.");
  }
  return std::string(ticket);
}

std::string origin_of(std::string_view url) {
  const std::size_t colon = url.find("://");
  if (colon == std::string_view::npos) return {};
  std::string scheme(url.substr(0, colon));
  std::transform(scheme.begin(), scheme.end(), scheme.begin(), lower);
  if (scheme != "http" && scheme != "https") return {};
  const std::string_view rest = url.substr(colon + 3);
  std::string host(rest.substr(0, rest.find_first_of("/?#")));
  std::transform(host.begin(), host.end(), host.begin(), lower);
  const std::string_view default_port = scheme == "http" ? ":80" : ":443";
  if (host.ends_with(default_port)) host.erase(host.size() - default_port.size());
  if (host.empty()) return {};
  return scheme + "://" + host;
}

}  // namespace diaphane::api::stream
