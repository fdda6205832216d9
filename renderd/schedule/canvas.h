#pragma once

#include "renderd/engine/frame_renderer.h"

namespace diaphane::render {

/// Input of plan_canvas(). Costs are those of this session on this device.
struct CanvasInput {
  Canvas viewport;               ///< size that the browser requested, pixels
  Canvas current;                ///< size rendered now; 0 x 0 before the first picture
  double seconds_per_pixel = 0;  ///< measured cost of one sample of one pixel; 0: unknown
  double seconds_first = 0;      ///< cost of a new picture without its samples
  bool moving = false;           ///< a gesture is under way, or this is a preview (Ledger::moving)
  std::size_t sharing = 1;       ///< number of moving sessions on the device, including this one
  /// Largest fraction of the viewport's sides while moving, as limited by the connection or the
  /// viewer.
  double largest_moving = 1;
};

/// Target time for one sample of a moving picture. It keeps the time from input to picture below
/// 100 ms (design: sessions, "lower resolution allowed").
inline constexpr double kMovingSampleSeconds = 0.06;
/// If several sessions move, one picture of each of them together should take no longer than a
/// picture of one session alone. It need not take less than this time, with which every moving
/// session gets a picture within 33 ms and a third of the device is left for the others.
inline constexpr double kSharedSeconds = 0.016;
/// Smallest factor by which sharing the device shrinks the sides of a picture.
inline constexpr double kSmallestShare = 0.5;
/// After this long without input a session is at rest and is rendered at full size.
inline constexpr double kRestSeconds = 0.15;
/// A picture at rest is preceded by a preview of the size used while moving if one sample of it
/// takes longer than this.
inline constexpr double kPreviewAboveSeconds = 2 * kMovingSampleSeconds;
/// Number of pixels of the first picture on a device whose speed is unknown.
inline constexpr double kProbePixels = 256.0 * 256.0;

/// Returns the size to render at. This is the viewport, or a fraction of it with even sides and
/// about the same shape while the picture moves and the device is slow or shared or the connection
/// is slow. No side is reduced below 16 pixels. Pure. The current size is kept while it still fits,
/// so that the picture does not flicker between sizes when the cost is near a threshold.
Canvas plan_canvas(const CanvasInput& input);

}  // namespace diaphane::render
