#pragma once

#include <cstdint>
#include <random>
#include <vector>

namespace diaphane::api::load {

/// One action of a user.
struct Act {
  enum class Kind {
    kLook,
    kDrag,
    kHide,    ///< shows another tab for this long
    kResize,  ///< resizes the window
    kReload,  ///< closes the page properly and reopens the session at once
    kCut      ///< loses the connection and reconnects after this long
  } kind = Kind::kLook;
  double seconds = 0;
};

/// A visit, from opening a session to ending or abandoning it.
struct Visit {
  std::uint32_t width = 0, height = 0;
  std::uint32_t read_pause_ms = 0;  ///< simulates a slow connection
  std::vector<Act> acts;
  bool ends_session = false;  ///< else it is abandoned, as by closing a laptop
  double pause = 0;           ///< seconds before the next visit
};

/// Draws a visit: a size from 160 x 90 to 1280 x 720, scaled by `scale`, with a slow connection in
/// one of five, and two to six actions of about `act_seconds`.
Visit draw_visit(std::mt19937_64& draws, double scale, double act_seconds);

}  // namespace diaphane::api::load
