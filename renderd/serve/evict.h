#pragma once

#include <chrono>
#include <optional>
#include <span>
#include <string>

namespace diaphane::render {

/// A session that holds a slot, as the choice below sees it. Plain data.
struct SlotHolder {
  std::string id;
  bool visitor = false;     ///< of somebody without an account, or a guest's own camera
  bool own_camera = false;  ///< its viewer would still see the group's picture
  std::optional<std::chrono::steady_clock::duration> abandoned_for;  ///< empty: somebody looks
  std::chrono::steady_clock::duration age{};
};

/// Which session gives up its slot, or none. For an account holder, in this order: a visitor's that
/// nobody looks at, a guest's own camera, a visitor's (of each kind the one that has had its slot
/// the longest), an account holder's that nobody looks at. For a visitor: only a visitor's that
/// nobody looks at.
std::optional<std::string> to_evict(std::span<const SlotHolder> holders, bool for_visitor);

}  // namespace diaphane::render
