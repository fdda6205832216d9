#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// Where a viewer wants less work than the worker would put into a picture.
struct Effort {
  double stop_error = 0;           ///< relative; 0: as the worker has it
  std::uint64_t stop_samples = 0;  ///< per pixel; 0: as the worker has it
  double moving_scale = 1;         ///< of the viewport's sides, while moving, at most
};

/// What a viewer wants to see now. Absolute, so that the newest replaces all before it.
struct Wanted {
  std::uint64_t version = 0;  ///< rises when another picture is wanted, and only then
  std::shared_ptr<const diaphane::v1::Scene> scene;
  Canvas viewport;
  std::uint64_t input_seq = 0;  ///< the newest input in it
  std::chrono::steady_clock::time_point last_input{};
  bool rest = false;  ///< that input said that it is the last of its gesture
  bool visible = true;
  bool room = true;  ///< its slot before the encoder is free and the viewer keeps up
  bool raw = false;  ///< no denoiser
  Effort effort;
  double moving_scale = 1;  ///< of the viewport's sides, while moving, at most: for the connection
  bool picture_again = false;  ///< a picture is due although nothing changed
  bool kernel_report = false;  ///< RenderClient::kernel is due with the next picture
};

/// What a picture is of.
struct FrameInfo {
  std::uint64_t epoch = 0;
  std::uint64_t input_seq = 0;
  std::uint64_t samples = 0;  ///< per pixel
  double error = 0;           ///< infinite while unknown
  /// Work for it since the epoch began: the scene made ready, samples, this picture of them.
  std::uint64_t render_us = 0;
  bool first_of_epoch = false;
  bool moving = false;     ///< code it for speed, not for quality
  bool converged = false;  ///< the last of its epoch
  bool denoised = false;
};

struct RenderedPicture {
  FrameInfo info;
  PictureRgb8 picture;
};

/// A viewer as the runner sees it. Called by one of the runner's threads at a time; never blocks
/// for long.
class RenderClient {
 public:
  virtual ~RenderClient() = default;
  /// It is another worker's picture that is helped with.
  virtual bool of_another_worker() const { return false; }
  /// It is of somebody without an account: such take a bounded share of the device together.
  virtual bool of_visitor() const { return false; }
  /// Also takes note that `picture_again` was read: the runner acts on it at once.
  virtual Wanted wanted() = 0;
  /// Wanted::version without a lock: polled while rendering.
  virtual std::uint64_t version() const noexcept = 0;
  /// The renderer took `wanted`; pictures of it carry `epoch`.
  virtual void began(std::uint64_t epoch, const Wanted& wanted) = 0;
  /// The renderer did not take `wanted`: the picture before it stays.
  virtual void refused(const Wanted& wanted, const Error& why) = 0;
  /// Its seconds are the session's own: of a device that it shares, no more than its part.
  virtual void rendered(const Batch& batch) = 0;
  virtual void picture(RenderedPicture picture) = 0;
  /// What renders it, after a picture for which it was wanted.
  virtual void kernel(const KernelReport&) {}
  /// The session cannot go on; the runner has dropped it.
  virtual void failed(const Error& why) = 0;
};

}  // namespace diaphane::render
