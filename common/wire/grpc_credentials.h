#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>

#include "common/wire/inner_tls.h"

namespace diaphane::wire {

/// Mutual TLS where `tls` is on, else none. The files are looked at again every `kLookedAt`.
std::shared_ptr<grpc::ServerCredentials> server_credentials(const InnerTls& tls);

/// One object for all channels of a program: it watches the files.
std::shared_ptr<grpc::ChannelCredentials> channel_credentials(const InnerTls& tls);

/// A channel to `address`; one that fails at once, with the reason in the log, where TLS is wanted
/// and there is none. `credentials`: of the same `tls`.
std::shared_ptr<grpc::Channel> open_channel(
    const std::string& address, const InnerTls& tls,
    const std::shared_ptr<grpc::ChannelCredentials>& credentials, grpc::ChannelArguments arguments);

/// Seconds.
inline constexpr unsigned kLookedAt = 2;

}  // namespace diaphane::wire
