#pragma once

#include <memory>
#include <utility>

#include "renderd/serve/live_session.h"

namespace diaphane::render {

/// Tells the session which codec an encoder's request concerns, and whether that codec is still in
/// use.
class LiveSession::Lane final : public FrameSink {
 public:
  Lane(std::weak_ptr<LiveSession> session, v1::Codec for_codec)
      : codec(for_codec), session_(std::move(session)) {}

  Admitted admit(const FrameInfo& frame) override {
    const auto session = session_.lock();
    return session ? session->admit(*this, frame) : Admitted{};
  }
  void coded(const FrameInfo& frame, CodedFrame data, double seconds) override {
    if (const auto session = session_.lock()) {
      session->coded(*this, frame, std::move(data), seconds);
    }
  }
  void dropped(const FrameInfo&, const Error& why) override {
    if (const auto session = session_.lock()) session->dropped(*this, why);
  }
  bool gives_way() const override {
    const auto session = session_.lock();
    return session && session->visitor_;
  }

  const v1::Codec codec;
  std::shared_ptr<EncodeLane> slot;  ///< set once, before the lane is shared

 private:
  const std::weak_ptr<LiveSession> session_;
};

}  // namespace diaphane::render
