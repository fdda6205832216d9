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

/// What a file's parts are cut to, and how many may be on their way before one is acknowledged.
inline constexpr std::size_t kFilePartBytes = std::size_t{128} << 10;
inline constexpr std::uint64_t kFilePartsInFlight = 8;
/// Of a file whose bytes are ready before its end: with more of them unsent no more is rendered.
inline constexpr std::size_t kMostUnsentFileBytes = std::size_t{8} << 20;

/// Where a file goes. Called from any thread, one call at a time and without a lock held; nothing
/// after `ended` or `stop`.
class FileSink {
 public:
  virtual ~FileSink() = default;
  virtual void progress(double done) = 0;
  virtual void part(std::uint64_t seq, std::string bytes, bool last) = 0;
  /// It could not be made.
  virtual void ended(const Error& why) = 0;
};

/// One file on its way: its pictures are rendered one by one behind everything else of the device,
/// coded in the pool, and its bytes sent as fast as they are taken. Thread-safe.
class FileWork : public std::enable_shared_from_this<FileWork> {
 public:
  /// `took`: the device's seconds, to be charged. All outlive it.
  FileWork(Runner& runner, EncodePool& pool, std::shared_ptr<FrameRenderer> renderer,
           std::unique_ptr<FileMaker> maker, std::weak_ptr<FileSink> sink,
           std::function<void(double seconds)> took);

  void start() { next(); }
  /// Nothing is rendered or sent any more, and what there is of the file is freed soon.
  void stop();
  /// Parts up to this one have come.
  void taken(std::uint64_t seq);

 private:
  void next();
  void rendered(Result<PictureRgb8> picture);
  void code(const PictureRgb8& picture, std::uint64_t samples);
  void fail_with(const Error& why);
  /// Cuts what is ready; true: there is room to go on rendering.
  bool put(std::string bytes, bool last);
  void send();

  Runner& runner_;
  EncodePool& pool_;
  const std::shared_ptr<FrameRenderer> renderer_;
  const std::unique_ptr<FileMaker> maker_;  // by one after the other: the lane, then the pool
  const std::weak_ptr<FileSink> sink_;
  const std::function<void(double)> took_;
  std::atomic<bool> stopped_{false};

  std::mutex sending_;  // one call of the sink at a time; taken before the other
  bool over_ = false;   // under that one: the last call was made
  std::mutex mutex_;
  std::size_t unsent() const { return ready_.size() - cut_; }
  std::string ready_;
  std::size_t cut_ = 0;  // of that, already
  bool whole_ = false;   // nothing comes after what is ready
  bool paused_ = false;  // too much is ready
  std::uint64_t sent_ = 0, taken_ = 0;
};

}  // namespace diaphane::render
