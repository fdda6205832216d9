#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "renderd/film/canvas.h"

namespace diaphane::render::bench {

/// A period in seconds from the start of a trace. A trace records when users arrived, dragged,
/// looked away and left.
struct Span {
  double begin = 0;
  double end = 0;
};

struct TraceSession {
  double arrives = 0;  ///< requests its first picture
  double leaves = 0;
  Canvas viewport{512, 512};
  std::string scene = "cranium";  ///< one of kTraceScenes
  std::vector<Span> gestures;     ///< one input every 1/60 s, and one at the end
  std::vector<Span> hidden;       ///< the page is not visible
};

struct Trace {
  std::string kind;
  std::uint64_t seed = 0;
  double seconds = 0;
  std::vector<TraceSession> sessions;
};

inline constexpr const char* kTraceKinds[] = {"interactive", "mixed", "idle"};
/// Scenes of tests/scenes/ with different costs and noise.
inline constexpr const char* kTraceScenes[] = {"cranium", "surface", "light-many"};
inline constexpr double kInputInterval = 1.0 / 60;

/// Draws a trace. A user drags, looks, and drags again, for log-normal durations whose medians
/// depend on the user: busy users drag for 1.5 s and look for 1 s, occasional ones 1 s and 5 s, and
/// idle ones 0.5 s and 30 s. Idle users look away for half of the pauses above 4 s. `interactive`
/// has only busy users. `mixed` has a quarter busy, half occasional and a quarter idle ones. `idle`
/// has an eighth occasional ones, and the rest are idle. All arrive within the first tenth of the
/// trace, and a twentieth leave before its end. Half of the viewports have 512 x 512 pixels, a
/// quarter 256 x 256 and a quarter 1024 x 768. Half of the sessions show the first scene, and a
/// quarter each of the others. Everything derives from `seed` with the project's own generator, so
/// that a trace is the same on every platform.
Trace make_trace(std::string_view kind, std::size_t sessions, double seconds, std::uint64_t seed);

struct TraceEvent {
  double at = 0;
  enum class Kind { kArrive, kInput, kHide, kShow, kLeave } kind = Kind::kInput;
  std::size_t session = 0;
  /// Whether an input is the last of its gesture, after which the user looks until the next event.
  /// The arrival counts as one.
  bool last = false;
};
/// Returns the events in order of time.
std::vector<TraceEvent> events_of(const Trace& trace);

std::string trace_json(const Trace& trace);
/// Parses a trace. Fails with kInvalid and the reason.
Result<Trace> trace_of_json(const std::string& text);

}  // namespace diaphane::render::bench
