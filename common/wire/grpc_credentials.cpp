#include "common/wire/grpc_credentials.h"

#include <grpc/grpc_security_constants.h>
#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>

#include <atomic>
#include <chrono>
#include <vector>

#include "common/log.h"

namespace diaphane::wire {
namespace {

namespace tls_api = grpc::experimental;

std::shared_ptr<tls_api::CertificateProviderInterface> watch(const TlsFiles& files) {
  return std::make_shared<tls_api::FileWatcherCertificateProvider>(files.key, files.certificate,
                                                                   files.ca, kLookedAt);
}

/// Returns true at most once per second, because a refused caller may call again at once.
bool is_time_to_log() {
  using Clock = std::chrono::steady_clock;
  static std::atomic<Clock::rep> next{0};
  const Clock::rep now = Clock::now().time_since_epoch().count();
  Clock::rep due = next.load();
  return now >= due &&
         next.compare_exchange_strong(due, now + Clock::duration(std::chrono::seconds(1)).count());
}

}  // namespace

std::shared_ptr<grpc::ServerCredentials> server_credentials(const InnerTls& tls) {
  if (!tls.on()) return grpc::InsecureServerCredentials();
  tls_api::TlsServerCredentialsOptions options(watch(tls.files));
  options.watch_root_certs();
  options.watch_identity_key_cert_pairs();
  options.set_cert_request_type(GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  return tls_api::TlsServerCredentials(options);
}

std::shared_ptr<grpc::ChannelCredentials> channel_credentials(const InnerTls& tls) {
  if (!tls.on()) return grpc::InsecureChannelCredentials();
  tls_api::TlsChannelCredentialsOptions options;
  options.set_certificate_provider(watch(tls.files));
  options.watch_root_certs();
  options.watch_identity_key_cert_pairs();
  return tls_api::TlsCredentials(options);
}

std::shared_ptr<grpc::Channel> open_channel(
    const std::string& address, const InnerTls& tls,
    const std::shared_ptr<grpc::ChannelCredentials>& credentials,
    grpc::ChannelArguments arguments) {
  if (tls.on()) {
    if (!tls.name.empty()) arguments.SetSslTargetNameOverride(tls.name);
  } else if (const auto plain = may_be_plain(address, tls); !plain) {
    log::error("plain_address", {{"reason", plain.error().message}});
    return grpc::CreateCustomChannel(address, nullptr, arguments);
  }
  return grpc::CreateCustomChannel(address, credentials, arguments);
}

grpc::Status require_role(const grpc::CallbackServerContext& call, Role role, const InnerTls& tls,
                          const std::string& method) {
  if (!tls.on() || !tls.roles) return grpc::Status::OK;
  std::vector<std::string> uris;
  for (const grpc::string_ref& uri :
       call.auth_context()->FindPropertyValues(GRPC_PEER_URI_PROPERTY_NAME)) {
    uris.emplace_back(uri.data(), uri.size());
  }
  if (has_role(uris, role)) return grpc::Status::OK;
  const std::string why = method + " requires a certificate with the role " +
                          std::string(to_string(role)) + " (URI " + role_uri(role) +
                          "), and the caller's certificate has " + describe_roles(uris) +
                          ". See docs/security.md.";
  if (is_time_to_log()) log::warning("role_refused", {{"message", why}});
  return {grpc::StatusCode::PERMISSION_DENIED, why};
}

}  // namespace diaphane::wire
