#pragma once

#include <cstdint>
#include <random>
#include <vector>

namespace diaphane::api::load {

/// One thing that somebody does at a picture.
struct Act {
  enum class Kind {
    kLook,
    kDrag,
    kHide,    ///< another tab for so long, then this one again
    kResize,  ///< of the window
    kReload,  ///< leaves in order and is back at once, in the same session
    kCut      ///< the line breaks, and is there again after so long
  } kind = Kind::kLook;
  double seconds = 0;
};

/// From opening a session to ending or forgetting it.
struct Visit {
  std::uint32_t width = 0, height = 0;
  std::uint32_t read_pause_ms = 0;  ///< a slow line
  std::vector<Act> acts;
  bool ends_session = false;  ///< else it is left behind, as a closed laptop leaves it
  double pause = 0;           ///< before the next visit, seconds
};

/// Sizes from 160 x 90 to 1280 x 720, scaled by `scale`; one in five reads slowly; two to six acts
/// of about `act_seconds`.
Visit draw_visit(std::mt19937_64& draws, double scale, double act_seconds);

}  // namespace diaphane::api::load
