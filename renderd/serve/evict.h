#pragma once

#include <chrono>
#include <optional>
#include <span>
#include <string>

namespace diaphane::render {

/// A session that holds a slot, with the data for the decision below.
struct SlotHolder {
  std::string id;
  bool visitor = false;      ///< whether it belongs to a visitor or is a guest's free camera
  bool free_camera = false;  ///< whether its viewer can return to the group's picture
  std::optional<std::chrono::steady_clock::duration> abandoned_for;  ///< nullopt: it has a viewer
  std::chrono::steady_clock::duration age{};
};

/// Returns the session that gives up its slot, or nullopt. For an account holder, in this order: an
/// abandoned session of a visitor, a guest's free camera, a visitor's session (in both cases the
/// one that has held its slot the longest), and an abandoned session of an account holder. For a
/// visitor, only an abandoned session of a visitor.
std::optional<std::string> to_evict(std::span<const SlotHolder> holders, bool for_visitor);

}  // namespace diaphane::render
