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

/// A worker to borrow.
struct Loan {
  std::string address;
  bool spare = false;  ///< renders only while nothing else needs its device
};

/// Other workers as assistants, over gRPC with api/proto/worker.proto. Connections are opened with
/// a session's first picture and reopened after failures, at most once per second. Besides the
/// permanent workers, some can be borrowed. Each session has an assistant per possible borrowed
/// worker, which counts as lost while it represents no worker.
class GrpcAssistants final : public AssistSource {
 public:
  /// `addresses`: host:port of the permanent workers. `most`: maximum number of workers borrowed at
  /// the same time.
  explicit GrpcAssistants(std::vector<std::string> addresses, const wire::InnerTls& tls = {},
                          std::size_t most = 0);
  /// Waits until all calls have ended. The assistants must have been destroyed before.
  ~GrpcAssistants() override;

  std::vector<std::unique_ptr<Assistant>> assistants(const AssistOrder& order) override;

  /// Sets the borrowed workers, at most `most`. All sessions release workers that are no longer
  /// listed, and reconnect to those that are listed with another `spare`.
  void borrow(const std::vector<Loan>& loans);
  std::vector<std::string> borrowed() const;  ///< their addresses
  /// Returns the borrowed workers that refused or were unreachable. They are not tried again until
  /// they have been removed and added.
  std::vector<std::string> refusing() const;
  /// Returns the seconds that other workers spent on this worker's pictures, as they report them.
  double helped_seconds() const { return *helped_seconds_; }

 private:
  std::shared_ptr<AssistPeer> open(const Loan& loan) const;

  const wire::InnerTls tls_;
  const std::shared_ptr<grpc::ChannelCredentials> credentials_;
  const std::shared_ptr<std::atomic<double>> helped_seconds_ =
      std::make_shared<std::atomic<double>>(0);
  std::vector<std::shared_ptr<AssistSlot>> fixed_, coming_;
  mutable std::mutex mutex_;
  /// Includes removed workers while their calls end.
  std::vector<std::shared_ptr<AssistPeer>> peers_;
};

}  // namespace diaphane::render
