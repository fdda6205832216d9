#pragma once

#include <cstdint>

// Events that several machines of a session handle (effects.h).

namespace diaphane::render {

/// The session's scene may have changed.
struct SceneChanged {};
struct ViewerLeft {
  std::uint64_t connection = 0;
};
struct SessionEnded {};

}  // namespace diaphane::render
