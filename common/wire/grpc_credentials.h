#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>

#include "common/wire/inner_tls.h"

namespace diaphane::wire {

/// Returns credentials for mutual TLS if `tls` is on, otherwise for plaintext. Reloads the files
/// every `kLookedAt` seconds.
std::shared_ptr<grpc::ServerCredentials> server_credentials(const InnerTls& tls);

/// Returns the client's counterpart. It watches the files, so a program uses one for all channels.
std::shared_ptr<grpc::ChannelCredentials> channel_credentials(const InnerTls& tls);

/// Returns a channel to `address`. If TLS is required but unavailable, the channel fails
/// immediately and the log states the reason. `credentials` must come from the same `tls`.
std::shared_ptr<grpc::Channel> open_channel(
    const std::string& address, const InnerTls& tls,
    const std::shared_ptr<grpc::ChannelCredentials>& credentials, grpc::ChannelArguments arguments);

/// Returns OK if the caller's certificate has the role, or if `tls` does not require roles.
/// Otherwise returns PERMISSION_DENIED with a message that names both, and logs it.
grpc::Status require_role(const grpc::CallbackServerContext& call, Role role, const InnerTls& tls,
                          const std::string& method);

/// Interval in seconds at which the files are checked for changes.
inline constexpr unsigned kLookedAt = 2;

}  // namespace diaphane::wire
