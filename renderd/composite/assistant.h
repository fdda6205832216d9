#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "renderd/composite/composite_volume.h"
#include "renderd/engine/frame_renderer.h"
#include "renderd/film/part.h"

namespace diaphane::render {

/// The work of an assistant until it gets another task.
struct AssistTask {
  /// Epoch of the compositor, which rises with each new picture. Parts of older epochs are useless.
  std::uint64_t epoch = 0;
  std::shared_ptr<const diaphane::v1::Scene> scene;
  /// Null if it is the volume of the renderer that made the assistant's.
  std::shared_ptr<const CompositeVolume> volume;
  Canvas canvas;
  Share share;
  bool guided = false;  ///< whether its parts include the guides of their rows
};

struct AssistPart {
  std::uint64_t epoch = 0;
  std::uint64_t sequence = 0;  ///< sequence of the share that it belongs to
  FilmPart film;
  double seconds = 0;       ///< device time of its samples
  std::uint64_t bytes = 0;  ///< number of bytes transferred
};

/// Progress of the picture that an assistant helps to render.
struct AssistNews {
  std::uint64_t samples = 0;  ///< per pixel
  double error = 0;           ///< Progress::error
};

/// Another device, of this process or another one, that helps to render a picture. Never blocks;
/// called by one thread at a time. Its delivered parts remain valid if it is lost, because they are
/// samples.
class Assistant {
 public:
  virtual ~Assistant() = default;
  /// Announces the scene of the next tasks. If it needs another copy of the volume, such as another
  /// phase, the assistant may be lost for a while.
  virtual void expect(const diaphane::v1::Scene&) {}
  /// Begins a task, which replaces the previous one.
  virtual void begin(const AssistTask& task) = 0;
  /// Returns the part that waits, if any. There is at most one: taking it makes room for the next,
  /// and an assistant whose part is not taken stops rendering.
  virtual std::optional<AssistPart> take(const AssistNews& news) = 0;
  /// Returns whether the assistant is lost, permanently or temporarily, so that it will not deliver
  /// parts of the task. A temporarily lost one can be asked to return by this call.
  virtual bool lost() = 0;
  /// Returns whether the assistant may pause for long, because it has only spare time. It then gets
  /// samples of the whole picture and no rows, which nobody else would render meanwhile.
  virtual bool may_pause() const { return false; }
  /// Returns the throughput at which its parts are transferred before they can be merged. Within a
  /// process, parts are not transferred; merging reads them where they are.
  virtual double bytes_per_second() const { return 1e12; }
};

}  // namespace diaphane::render
