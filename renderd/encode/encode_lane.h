#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>

#include "renderd/encode/encode_pool.h"
#include "renderd/encode/encoder.h"
#include "renderd/session/pictures.h"

namespace diaphane::render {

/// Who receives a session's frames. Called from an encoding thread, one call at a time.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  /// kGo: encode and hand over by `coded` or `dropped`. kWait: keep it until `poke`.
  virtual Admitted admit(const FrameInfo& frame) = 0;
  virtual void coded(const FrameInfo& frame, CodedFrame data, double seconds) = 0;
  virtual void dropped(const FrameInfo& frame, const Error& why) = 0;
};

/// One session's way to the encoder: a slot for one picture, in which the latest wins, and the
/// session's own encoder. A picture waits in the slot while its viewer has no room, so nobody's
/// slow connection fills a queue or holds a thread.
class EncodeLane : public std::enable_shared_from_this<EncodeLane> {
 public:
  EncodeLane(EncodePool& pool, std::unique_ptr<Encoder> encoder, std::weak_ptr<FrameSink> sink);

  /// Replaces whatever waits.
  void submit(RenderedPicture picture);
  /// Room may have been made.
  void poke();
  bool slot_free() const;
  /// Pictures replaced by a newer one, or dropped as out of date, before they were encoded.
  std::uint64_t skipped() const;

 private:
  void schedule(std::unique_lock<std::mutex>& lock);
  void run();

  EncodePool& pool_;
  const std::unique_ptr<Encoder> encoder_;
  const std::weak_ptr<FrameSink> sink_;
  mutable std::mutex mutex_;
  std::optional<RenderedPicture> slot_;
  bool scheduled_ = false;  // a job of this lane is queued or running
  bool poked_ = false;      // while it ran
  std::uint64_t skipped_ = 0;
};

}  // namespace diaphane::render
