#pragma once

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// What the size of the next picture is decided from. Costs are of this device for this session.
struct CanvasQuestion {
  Canvas viewport;               ///< what the browser asked for, pixels
  Canvas current;                ///< what is rendered now; 0 x 0 before the first picture
  double seconds_per_pixel = 0;  ///< measured cost of one sample of one pixel; 0: unknown
  double seconds_first = 0;      ///< of a new picture beside its samples
  bool moving = false;           ///< input came within the last moment
  std::size_t sharing = 1;       ///< sessions of the device that move, this one among them
  double largest_moving = 1;     ///< of the viewport's sides, while moving: for the connection
};

/// One sample of a moving picture should take at most about this long: input to picture stays
/// near 100 ms (design: sessions, "lower resolution allowed").
inline constexpr double kMovingSampleSeconds = 0.08;
/// Where several move, one picture of each should take no longer than one of them alone does, but
/// need not be shorter than this: a picture for everybody within 33 ms, and a third for the others.
inline constexpr double kSharedSeconds = 0.016;
/// For the others' sake a side is made smaller by this at most.
inline constexpr double kSmallestShare = 0.5;
/// Input rests after this long: the full size is rendered.
inline constexpr double kRestSeconds = 0.15;
/// Pixels of the very first picture on a device whose speed nobody has measured.
inline constexpr double kProbePixels = 256.0 * 256.0;

/// The size to render at: the viewport's, or, while moving on a slow or a crowded device or to a
/// viewer behind a slow connection, an even fraction of it with the same shape, never below 16
/// pixels a side. Pure. A current size that is still fitting is kept, so that a picture does not
/// flicker between sizes when the cost is near a border.
Canvas plan_canvas(const CanvasQuestion& question);

}  // namespace diaphane::render
