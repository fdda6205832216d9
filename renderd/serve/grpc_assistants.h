#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "common/wire/inner_tls.h"
#include "renderd/composite/composite_engine.h"

namespace grpc {
class ChannelCredentials;
}

namespace diaphane::render {

struct AssistPeer;
struct AssistSlot;

/// Other workers as assistants, by api/proto/worker.proto over gRPC. Connections are opened with a
/// session's first picture and again, each second at most, when they broke. Beside those that are
/// always there, some may come and go: each session has as many assistants more as there may be,
/// each of them lost while it stands for nobody.
class GrpcAssistants final : public AssistSource {
 public:
  /// `addresses`: host:port of each. `most`: that come and go, at once.
  explicit GrpcAssistants(std::vector<std::string> addresses, const wire::InnerTls& tls = {},
                          std::size_t most = 0);
  /// Waits until no call is under way; the assistants must have gone.
  ~GrpcAssistants() override;

  std::vector<std::unique_ptr<Assistant>> assistants(const AssistOrder& order) override;

  /// Those that come and go, from now on: no more than `most`. Who is not among them any more is
  /// left at once, by all sessions.
  void borrow(const std::vector<std::string>& addresses);
  std::vector<std::string> borrowed() const;  ///< their addresses
  /// Of these: who refused, or could not be reached. It is not asked again until it went and came.
  std::vector<std::string> refusing() const;
  /// That others worked, by what they say.
  double helped_seconds() const { return *helped_seconds_; }

 private:
  std::shared_ptr<AssistPeer> open(const std::string& address) const;

  const wire::InnerTls tls_;
  const std::shared_ptr<grpc::ChannelCredentials> credentials_;
  const std::shared_ptr<std::atomic<double>> helped_seconds_ =
      std::make_shared<std::atomic<double>>(0);
  std::vector<std::shared_ptr<AssistSlot>> fixed_, coming_;
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<AssistPeer>> peers_;  ///< also those that went, while calls end
};

}  // namespace diaphane::render
