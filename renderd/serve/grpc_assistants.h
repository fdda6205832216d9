#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/wire/inner_tls.h"
#include "renderd/composite/composite_engine.h"

namespace diaphane::render {

/// Other workers as assistants, by api/proto/worker.proto over gRPC. Connections are opened with a
/// session's first picture and again, each second at most, when they broke.
class GrpcAssistants final : public AssistSource {
 public:
  /// `addresses`: host:port of each.
  explicit GrpcAssistants(std::vector<std::string> addresses, const wire::InnerTls& tls = {});
  /// Waits until no call is under way; the assistants must have gone.
  ~GrpcAssistants() override;

  std::vector<std::unique_ptr<Assistant>> assistants(const AssistOrder& order) override;

 private:
  struct Peer;
  std::vector<std::shared_ptr<Peer>> peers_;
};

}  // namespace diaphane::render
