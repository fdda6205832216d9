#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// A viewer's limits on the work for their picture.
struct Effort {
  double stop_error = 0;           ///< relative; 0: the worker's default
  std::uint64_t stop_samples = 0;  ///< per pixel; 0: the worker's default
  double moving_scale = 1;         ///< maximum size while moving, relative to the viewport's sides
};

/// A viewer's current request. It is complete, so that the newest replaces all earlier ones.
struct ViewRequest {
  std::uint64_t version = 0;  ///< rises exactly when another picture is requested
  std::shared_ptr<const diaphane::v1::Scene> scene;
  /// The copy of the volume that the scene shows; null: that of the renderer.
  std::shared_ptr<const DeviceVolume> volume;
  Canvas viewport;
  std::uint64_t input_seq = 0;  ///< the newest input that it contains
  std::chrono::steady_clock::time_point last_input{};
  bool rest = false;       ///< whether that input is the last of its gesture
  bool full_size = false;  ///< whether no picture may be smaller than the viewport
  bool visible = true;
  bool room = true;  ///< the encoder's slot is free and the viewer keeps up
  bool raw = false;  ///< whether the picture is shown without denoising
  Effort effort;
  /// Maximum size while moving that the connection permits, relative to the viewport's sides.
  double moving_scale = 1;
  bool picture_again = false;  ///< a picture is due although nothing changed
  bool kernel_report = false;  ///< RenderClient::kernel is due with the next picture
};

/// Describes a picture.
struct FrameInfo {
  std::uint64_t epoch = 0;
  std::uint64_t input_seq = 0;
  std::uint64_t samples = 0;  ///< per pixel
  double error = 0;           ///< infinite if unknown
  double stops = 0;           ///< Progress::stops
  /// Time spent on it since the epoch began: preparing the scene, samples, and this picture.
  std::uint64_t render_us = 0;
  std::uint32_t volume_phase = 0;  ///< phase of the scan
  bool first_of_epoch = false;
  bool moving = false;     ///< encode it for speed, not for quality
  bool converged = false;  ///< the last picture of its epoch
  bool denoised = false;
};

struct RenderedPicture {
  FrameInfo info;
  PictureRgb8 picture;
};

/// The runner's interface to a session, which may have any number of viewers. Only one of the
/// runner's threads calls it at a time. Its functions must not block for long.
class RenderClient {
 public:
  virtual ~RenderClient() = default;
  /// Returns whether the picture is rendered for another worker.
  virtual bool of_another_worker() const { return false; }
  /// Returns whether it is rendered only while no other picture could become better.
  virtual bool with_spare_time() const { return false; }
  /// Returns whether it belongs to a user without an account. Such clients together get a limited
  /// share of the device.
  virtual bool of_visitor() const { return false; }
  /// Returns the request and marks its `picture_again` as read, because the runner acts on it at
  /// once.
  virtual ViewRequest requested() = 0;
  /// Returns ViewRequest::version without a lock. Polled while rendering.
  virtual std::uint64_t version() const noexcept = 0;
  /// Reports that the renderer accepted `requested`. The new pictures carry `epoch`.
  virtual void began(std::uint64_t epoch, const ViewRequest& requested) = 0;
  /// Reports that the renderer refused `requested`. The previous picture stays.
  virtual void refused(const ViewRequest& requested, const Error& why) = 0;
  /// Reports a batch of samples. Its seconds are the session's own, at most its part of a shared
  /// device.
  virtual void rendered(const Batch& batch) = 0;
  /// Reports the film's progress after a batch. Its seconds include preparing the scene. `moving`:
  /// FrameInfo::moving.
  virtual void progressed(const Progress&, bool /*moving*/) {}
  virtual void picture(RenderedPicture picture) = 0;
  /// Reports how pictures are rendered, after a picture for which this was requested.
  virtual void kernel(const KernelReport&) {}
  /// Reports that the session cannot continue. The runner has dropped it.
  virtual void failed(const Error& why) = 0;
};

}  // namespace diaphane::render
