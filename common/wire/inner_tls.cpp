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
  // More than one colon without brackets: an address of IPv6 alone.
  const std::size_t colon = address.find(':');
  const bool has_port =
      colon != std::string_view::npos && address.find(':', colon + 1) == std::string_view::npos;
  return has_port ? address.substr(0, colon) : address;
}

}  // namespace

Result<void> check(const TlsFiles& files) {
  const std::unique_ptr<SSL_CTX, FreeContext> context(SSL_CTX_new(TLS_method()));
  if (!context) return fail(ErrorCode::kInternal, "no TLS");
  if (SSL_CTX_load_verify_locations(context.get(), files.ca.c_str(), nullptr) != 1) {
    return fail(ErrorCode::kInvalid, files.ca + " has no certificates in PEM");
  }
  if (SSL_CTX_use_certificate_chain_file(context.get(), files.certificate.c_str()) != 1) {
    return fail(ErrorCode::kInvalid, files.certificate + " has no certificate in PEM");
  }
  if (SSL_CTX_use_PrivateKey_file(context.get(), files.key.c_str(), SSL_FILETYPE_PEM) != 1) {
    return fail(ErrorCode::kInvalid, files.key + " is no key in PEM, or of another certificate");
  }
  return {};
}

bool read_plain_allowed(ConfigReader& in) {
  return in.one_of("inner-plain", "1: other machines may be reached without TLS", {"0", "1"},
                   "0") == "1";
}

InnerTls read_inner_tls(ConfigReader& in) {
  InnerTls tls;
  tls.files.ca = in.text("inner-tls-ca", "PEM: who signs the certificates of our own programs", "");
  tls.files.certificate = in.text("inner-tls-certificate", "PEM: this program's certificate", "");
  tls.files.key = in.text("inner-tls-key", "PEM: its key", "");
  tls.name =
      in.text("inner-tls-name",
              "name that a gRPC server's certificate must have; empty: its address's host", "");
  tls.plain_allowed = read_plain_allowed(in);
  const int given = static_cast<int>(!tls.files.ca.empty()) +
                    static_cast<int>(!tls.files.certificate.empty()) +
                    static_cast<int>(!tls.files.key.empty());
  if (given != 0 && given != 3) {
    in.mistake("--inner-tls-ca, --inner-tls-certificate and --inner-tls-key belong together");
  } else if (given == 3) {
    if (const auto usable = check(tls.files); !usable) {
      in.mistake("--inner-tls: " + usable.error().message);
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
                  " is another machine, and there is no TLS to it (docs/security.md: "
                  "--inner-tls-ca and those with it, rediss:// for Redis; or --inner-plain 1 "
                  "where the network itself is private)");
}

void check_address(ConfigReader& in, std::string_view name, std::string_view address,
                   const InnerTls& tls) {
  const std::string setting = "--" + std::string(name) + ": ";
  if (wants_tls(address)) {
    if (!tls.on()) in.mistake(setting + "rediss:// needs --inner-tls-ca and those with it");
  } else if (const auto plain = may_be_plain(address, tls); !address.empty() && !plain) {
    in.mistake(setting + plain.error().message);
  }
}

}  // namespace diaphane::wire
