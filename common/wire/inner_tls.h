#pragma once

#include <string>
#include <string_view>

#include "common/config.h"
#include "common/result.h"

namespace diaphane::wire {

/// PEM files: whom we trust, and who we are. Read again when they change, so that certificates can
/// be renewed under a running program.
struct TlsFiles {
  std::string ca;           ///< one or more certificates; everybody else is refused
  std::string certificate;  ///< ours, with what is between it and the CA behind it
  std::string key;
};

/// How programs of Diaphane reach one another, and Redis.
struct InnerTls {
  TlsFiles files;
  /// What the certificate of a gRPC server must be for; empty: for the host of its address.
  std::string name;
  /// Whoever runs it has said that another machine may be reached without TLS (the network itself
  /// is private, or encrypted).
  bool plain_allowed = false;

  bool on() const { return !files.ca.empty(); }
};

/// Setting inner-plain alone, of a program that has no TLS of its own.
bool read_plain_allowed(ConfigReader& in);

/// Settings inner-tls-ca, inner-tls-certificate, inner-tls-key, inner-tls-name, inner-plain. Files
/// that are not there, are none, or do not fit together are mistakes.
InnerTls read_inner_tls(ConfigReader& in);

/// kInvalid, with the file, when these cannot be used.
Result<void> check(const TlsFiles& files);

/// 127.0.0.0/8, ::1, localhost or unix:/path. `address`: one of these, or host:port.
bool is_this_machine(std::string_view address);

/// kInvalid, and in words what to do, where `address` would be reached without TLS and must not be.
Result<void> may_be_plain(std::string_view address, const InnerTls& tls);

/// A mistake where setting `name` has an address that must not be plain, or wants TLS (rediss://)
/// that there is none for.
void check_address(ConfigReader& in, std::string_view name, std::string_view address,
                   const InnerTls& tls);

}  // namespace diaphane::wire
