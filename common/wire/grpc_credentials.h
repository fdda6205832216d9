#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>

#include "common/wire/inner_tls.h"

namespace diaphane::wire {

/// Mutual TLS if `tls` is on, otherwise plaintext. Reloads the files every `kLookedAt` seconds.
std::shared_ptr<grpc::ServerCredentials> server_credentials(const InnerTls& tls);

/// Watches the files; use one object for all channels of a program.
std::shared_ptr<grpc::ChannelCredentials> channel_credentials(const InnerTls& tls);

/// Returns a channel to `address`. If TLS is required but unavailable, the channel fails
/// immediately and the log states the reason. `credentials` must come from the same `tls`.
std::shared_ptr<grpc::Channel> open_channel(
    const std::string& address, const InnerTls& tls,
    const std::shared_ptr<grpc::ChannelCredentials>& credentials, grpc::ChannelArguments arguments);

/// OK if the caller's certificate has the role, or if `tls` does not require roles. Otherwise
/// PERMISSION_DENIED with a message that names both, which is also logged.
grpc::Status require_role(const grpc::CallbackServerContext& call, Role role, const InnerTls& tls,
                          const std::string& method);

/// Seconds.
inline constexpr unsigned kLookedAt = 2;

}  // namespace diaphane::wire
