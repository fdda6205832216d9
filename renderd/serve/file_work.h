#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "renderd/encode/encode_pool.h"
#include "renderd/schedule/runner.h"
#include "renderd/serve/file_maker.h"

namespace diaphane::render {

/// Size of a file's parts, and how many may be unacknowledged.
inline constexpr std::size_t kFilePartBytes = std::size_t{128} << 10;
inline constexpr std::uint64_t kFilePartsInFlight = 8;
/// Rendering pauses while more bytes than this are unsent.
inline constexpr std::size_t kMostUnsentFileBytes = std::size_t{8} << 20;

/// Receives a file. Called from any thread, one call at a time and without a lock. No call follows
/// `ended` or `stop`.
class FileSink {
 public:
  virtual ~FileSink() = default;
  virtual void progress(double done) = 0;
  virtual void part(std::uint64_t seq, std::string bytes, bool last) = 0;
  /// Reports that the file could not be made.
  virtual void ended(const Error& why) = 0;
};

/// Makes and sends one file. Its pictures are rendered one by one as stills of the lowest rank,
/// encoded in the pool, and sent as fast as the receiver takes them. Thread-safe.
class FileWork : public std::enable_shared_from_this<FileWork> {
 public:
  /// Calls `ready` once with the copy of the volume that a scene shows.
  using FindVolume =
      std::function<void(const diaphane::v1::Scene& scene,
                         std::function<void(Result<std::shared_ptr<const DeviceVolume>>)> ready)>;

  /// `took` receives the device seconds to charge. `find` is null if all pictures show the volume
  /// of the renderer. `runner` and `pool` must outlive this object.
  FileWork(Runner& runner, EncodePool& pool, std::shared_ptr<FrameRenderer> renderer,
           std::unique_ptr<FileMaker> maker, std::weak_ptr<FileSink> sink,
           std::function<void(double seconds)> took, FindVolume find = nullptr);

  void start() { next(); }
  /// Stops rendering and sending. The file's memory is freed soon afterwards.
  void stop();
  /// Acknowledges all parts up to `seq`.
  void taken(std::uint64_t seq);

 private:
  void next();
  void submit(StillJob job);
  void rendered(Result<PictureRgb8> picture);
  void code(const PictureRgb8& picture, std::uint64_t samples);
  void fail_with(const Error& why);
  /// Cuts the bytes into parts. Returns whether there is room to continue rendering.
  bool put(std::string bytes, bool last);
  void send();

  Runner& runner_;
  EncodePool& pool_;
  const std::shared_ptr<FrameRenderer> renderer_;
  // Used by one thread at a time: first the lane, then the pool.
  const std::unique_ptr<FileMaker> maker_;
  const std::weak_ptr<FileSink> sink_;
  const std::function<void(double)> took_;
  const FindVolume find_;
  std::atomic<bool> stopped_{false};

  std::mutex sending_;  // serialises calls of the sink; locked before the other mutex
  bool over_ = false;   // guarded by sending_: the last call was made
  std::mutex mutex_;
  std::size_t unsent() const { return ready_.size() - cut_; }
  std::string ready_;
  std::size_t cut_ = 0;    // bytes of `ready_` that are in parts
  bool complete_ = false;  // no bytes follow the ready ones
  bool paused_ = false;    // too many bytes are ready
  std::uint64_t sent_ = 0, taken_ = 0;
};

}  // namespace diaphane::render
