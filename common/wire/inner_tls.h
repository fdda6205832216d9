#pragma once

#include <string>
#include <string_view>

#include "common/config.h"
#include "common/result.h"
#include "common/wire/roles.h"

namespace diaphane::wire {

/// PEM files with the trusted CA and our own identity. They are reloaded when they change, so that
/// certificates can be renewed while the program runs.
struct TlsFiles {
  std::string ca;           ///< one or more trusted certificates
  std::string certificate;  ///< our certificate, followed by the intermediate certificates
  std::string key;
};

/// Transport security between Diaphane's services, and from them to Redis.
struct InnerTls {
  TlsFiles files;
  /// Name that a gRPC server's certificate must have. Empty means the host of its address.
  std::string name;
  /// Requires a caller's certificate to have the role of a method. If false, every certificate of
  /// the CA may call every method.
  bool roles = true;
  /// Allows connections to remote hosts without TLS, because the network itself is private or
  /// encrypted.
  bool plain_allowed = false;

  bool on() const { return !files.ca.empty(); }
};

/// Reads only the setting inner-plain, for a program that does not use TLS itself.
bool read_plain_allowed(ConfigReader& in);

/// Reads the settings inner-tls-ca, inner-tls-certificate, inner-tls-key, inner-tls-name,
/// inner-tls-roles and inner-plain. Reports as mistakes files that are missing, invalid or
/// inconsistent, and a certificate without the role of this program.
InnerTls read_inner_tls(ConfigReader& in, Role own);

/// Checks that the files can be used. Returns kInvalid with the name of one that cannot.
Result<void> check(const TlsFiles& files);

/// Returns whether `address` (a host or host:port) is 127.0.0.0/8, ::1, localhost or unix:/path.
bool is_this_machine(std::string_view address);

/// Checks that `address` may be reached without TLS. Returns kInvalid, with advice, if not.
Result<void> may_be_plain(std::string_view address, const InnerTls& tls);

/// Reports a mistake if the setting `name` has an address that requires TLS (also by rediss://) and
/// no TLS is configured.
void check_address(ConfigReader& in, std::string_view name, std::string_view address,
                   const InnerTls& tls);

/// Reads the setting redis. Reports as a mistake an invalid address, and one that requires TLS
/// while no TLS is configured.
std::string read_redis(ConfigReader& in, const InnerTls& tls);

}  // namespace diaphane::wire
