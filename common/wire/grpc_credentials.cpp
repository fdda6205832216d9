#include "common/wire/grpc_credentials.h"

#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>

#include "common/log.h"

namespace diaphane::wire {
namespace {

namespace tls_api = grpc::experimental;

std::shared_ptr<tls_api::CertificateProviderInterface> watch(const TlsFiles& files) {
  return std::make_shared<tls_api::FileWatcherCertificateProvider>(files.key, files.certificate,
                                                                   files.ca, kLookedAt);
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

}  // namespace diaphane::wire
