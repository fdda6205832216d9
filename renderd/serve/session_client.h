#pragma once

#include "renderd/serve/live_session.h"

namespace diaphane::render {

/// The runner's interface to a session. Belongs to the session, which outlives it.
class LiveSession::Client final : public RenderClient {
 public:
  explicit Client(LiveSession& session) : session_(session) {}

  bool of_visitor() const override { return session_.visitor_; }
  ViewRequest requested() override;
  std::uint64_t version() const noexcept override {
    return session_.version_.load(std::memory_order_relaxed);
  }
  void began(std::uint64_t epoch, const ViewRequest& requested) override;
  void refused(const ViewRequest& requested, const Error& why) override;
  void rendered(const Batch& batch) override;
  void progressed(const Progress& progress, bool moving) override;
  void picture(RenderedPicture picture) override;
  void kernel(const KernelReport& report) override;
  void failed(const Error& why) override;

 private:
  LiveSession& session_;
};

}  // namespace diaphane::render
