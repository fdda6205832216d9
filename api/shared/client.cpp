#include "api/shared/client.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>

namespace diaphane::api {
namespace {

constexpr std::size_t kIpv4Bytes = 2, kIpv6Bytes = 4;

std::string network(int family, const unsigned char* address, std::size_t kept) {
  std::array<unsigned char, 16> prefix{};
  std::copy_n(address, kept, prefix.begin());
  std::array<char, INET6_ADDRSTRLEN> text{};
  ::inet_ntop(family, prefix.data(), text.data(), text.size());
  return std::string(text.data()) + "/" + std::to_string(kept * 8);
}

}  // namespace

std::string coarse_network(const std::string& address) {
  std::array<unsigned char, 16> bytes{};
  if (::inet_pton(AF_INET, address.c_str(), bytes.data()) == 1) {
    return network(AF_INET, bytes.data(), kIpv4Bytes);
  }
  if (::inet_pton(AF_INET6, address.c_str(), bytes.data()) != 1) return {};
  constexpr std::array<unsigned char, 12> kMappedIpv4{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
  if (std::equal(kMappedIpv4.begin(), kMappedIpv4.end(), bytes.begin())) {
    return network(AF_INET, bytes.data() + kMappedIpv4.size(), kIpv4Bytes);
  }
  return network(AF_INET6, bytes.data(), kIpv6Bytes);
}

}  // namespace diaphane::api
