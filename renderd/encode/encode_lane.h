#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>

#include "renderd/encode/encode_pool.h"
#include "renderd/encode/encoder.h"
#include "renderd/session/pictures.h"

namespace diaphane::render {

/// Receives a session's frames. Called from an encoding thread, one call at a time.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  /// kGo: the frame is encoded and passed to `coded` or `dropped`. kWait: it waits for `poke`.
  virtual Admitted admit(const FrameInfo& frame) = 0;
  virtual void coded(const FrameInfo& frame, CodedFrame data, double seconds) = 0;
  virtual void dropped(const FrameInfo& frame, const Error& why) = 0;
  /// Returns whether even moving pictures of this session yield to those of other sessions.
  virtual bool gives_way() const { return false; }
};

/// Encodes the pictures of one session with its own encoder. A slot holds one picture, and the
/// latest replaces it. A picture waits in the slot while its viewer has no room, so that a slow
/// connection neither fills a queue nor blocks a thread.
class EncodeLane : public std::enable_shared_from_this<EncodeLane> {
 public:
  EncodeLane(EncodePool& pool, std::unique_ptr<Encoder> encoder, std::weak_ptr<FrameSink> sink);

  /// Replaces the waiting picture.
  void submit(RenderedPicture picture);
  /// Tries to encode the waiting picture, because the viewer may have room again.
  void poke();
  bool slot_free() const;
  /// Returns the number of pictures that were replaced or outdated before they were encoded.
  std::uint64_t skipped() const;

 private:
  void schedule(std::unique_lock<std::mutex>& lock);
  void run();

  EncodePool& pool_;
  const std::unique_ptr<Encoder> encoder_;
  const std::weak_ptr<FrameSink> sink_;
  mutable std::mutex mutex_;
  std::optional<RenderedPicture> slot_;
  bool scheduled_ = false;  // whether a job of this lane is queued or running
  bool poked_ = false;      // whether schedule() was called while the job ran
  std::uint64_t skipped_ = 0;
};

}  // namespace diaphane::render
