#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "renderd/engine/frame_renderer.h"
#include "renderd/film/part.h"

namespace diaphane::render {

/// What an assistant is to render, until it gets another task.
struct AssistTask {
  /// Of the compositor's: rises with each new picture. Parts of older ones are of no use.
  std::uint64_t epoch = 0;
  std::shared_ptr<const diaphane::v1::Scene> scene;
  Canvas canvas;
  Share share;
};

struct AssistPart {
  std::uint64_t epoch = 0;
  std::uint64_t sequence = 0;  ///< of the task's share
  FilmPart film;
  double seconds = 0;       ///< that its samples took on the device
  std::uint64_t bytes = 0;  ///< as it was moved
};

/// How far the picture is that an assistant helps with.
struct AssistNews {
  std::uint64_t samples = 0;
  double error = 0;
};

/// Another device that renders for a picture: of this process or of another. Never blocks; called
/// by one thread at a time. What it has delivered stays valid when it is lost: it is samples.
class Assistant {
 public:
  virtual ~Assistant() = default;
  /// Replaces the task before.
  virtual void begin(const AssistTask& task) = 0;
  /// The part that waits, if one does. There is at most one: taking it makes room for the next, and
  /// an assistant whose part is not taken comes to rest.
  virtual std::optional<AssistPart> take(const AssistNews& news) = 0;
  /// For good, or for now: nothing will come of the task. One that can comes back when asked.
  virtual bool lost() = 0;
  /// That its parts come over, before they can be merged. Within a process they stay where they are
  /// until then, and merging reads them there.
  virtual double bytes_per_second() const { return 1e12; }
};

}  // namespace diaphane::render
