#include "common/wire/inner_tls.h"

#include <arpa/inet.h>
#include <openssl/ssl.h>

#include <memory>

#include "common/connect.h"
#include "common/wire/redis_address.h"

namespace diaphane::wire {
namespace {

struct FreeContext {
  void operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
};

std::string_view host_of(std::string_view address) {
  if (address.starts_with('[')) return address.substr(1, address.find(']') - 1);
  // More than one colon without brackets means an IPv6 address without a port.
  const std::size_t colon = address.find(':');
  const bool has_port =
      colon != std::string_view::npos && address.find(':', colon + 1) == std::string_view::npos;
  return has_port ? address.substr(0, colon) : address;
}

}  // namespace

Result<void> check(const TlsFiles& files) {
  const std::unique_ptr<SSL_CTX, FreeContext> context(SSL_CTX_new(TLS_method()));
  if (!context) return fail(ErrorCode::kInternal, "cannot initialise TLS");
  if (SSL_CTX_load_verify_locations(context.get(), files.ca.c_str(), nullptr) != 1) {
    return fail(ErrorCode::kInvalid, files.ca + " contains no PEM certificates");
  }
  if (SSL_CTX_use_certificate_chain_file(context.get(), files.certificate.c_str()) != 1) {
    return fail(ErrorCode::kInvalid, files.certificate + " contains no PEM certificate");
  }
  if (SSL_CTX_use_PrivateKey_file(context.get(), files.key.c_str(), SSL_FILETYPE_PEM) != 1) {
    return fail(ErrorCode::kInvalid,
                files.key + " is not a PEM private key or does not match the certificate");
  }
  return {};
}

bool read_plain_allowed(ConfigReader& in) {
  return in.one_of("inner-plain", "1 allows connections to remote hosts without TLS", {"0", "1"},
                   "0") == "1";
}

InnerTls read_inner_tls(ConfigReader& in, Role own) {
  InnerTls tls;
  tls.files.ca =
      in.text("inner-tls-ca",
              "PEM file with the CA that signs the certificates of Diaphane's services", "");
  tls.files.certificate =
      in.text("inner-tls-certificate", "PEM file with this service's certificate", "");
  tls.files.key = in.text("inner-tls-key", "PEM file with this service's private key", "");
  tls.name = in.text(
      "inner-tls-name",
      "name that a gRPC server's certificate must have (empty = the host of its address)", "");
  tls.roles = in.one_of("inner-tls-roles",
                        "0 accepts certificates without roles, so that each may call every method",
                        {"0", "1"}, "1") == "1";
  tls.plain_allowed = read_plain_allowed(in);
  const int given = static_cast<int>(!tls.files.ca.empty()) +
                    static_cast<int>(!tls.files.certificate.empty()) +
                    static_cast<int>(!tls.files.key.empty());
  if (given != 0 && given != 3) {
    in.mistake("--inner-tls-ca, --inner-tls-certificate and --inner-tls-key must be set together");
  } else if (given == 3) {
    if (const auto usable = check(tls.files); !usable) {
      in.mistake("--inner-tls: " + usable.error().message);
    } else if (const auto right = check_role(tls.files.certificate, own); tls.roles && !right) {
      in.mistake("--inner-tls-certificate: " + right.error().message);
    }
  }
  return tls;
}

bool is_this_machine(std::string_view address) {
  if (!unix_path(address).empty()) return true;
  const std::string host(host_of(address));
  in_addr four{};
  if (inet_pton(AF_INET, host.c_str(), &four) == 1) return ntohl(four.s_addr) >> 24 == 127;
  return host == "localhost" || host == "::1";
}

Result<void> may_be_plain(std::string_view address, const InnerTls& tls) {
  if (tls.plain_allowed || is_this_machine(address)) return {};
  return fail(ErrorCode::kInvalid,
              std::string(address) +
                  " is a remote host, and the connection would not use TLS. Set --inner-tls-ca, "
                  "--inner-tls-certificate and --inner-tls-key (and use rediss:// for Redis), or "
                  "set --inner-plain 1 if the network itself is private. See docs/security.md.");
}

void check_address(ConfigReader& in, std::string_view name, std::string_view address,
                   const InnerTls& tls) {
  const std::string setting = "--" + std::string(name) + ": ";
  if (wants_tls(address)) {
    if (!tls.on())
      in.mistake(setting +
                 "rediss:// requires --inner-tls-ca, --inner-tls-certificate and --inner-tls-key");
  } else if (const auto plain = may_be_plain(address, tls); !address.empty() && !plain) {
    in.mistake(setting + plain.error().message);
  }
}

std::string read_redis(ConfigReader& in, const InnerTls& tls) {
  const std::string address =
      in.text("redis", "Redis address: host:port, rediss://host:port for TLS, or unix:PATH");
  if (const auto parsed = parse_redis_address(address)) {
    check_address(in, "redis", address, tls);
  } else if (!address.empty()) {
    in.mistake("--redis: " + parsed.error().message);
  }
  return address;
}

}  // namespace diaphane::wire
