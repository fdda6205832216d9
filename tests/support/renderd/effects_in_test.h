#pragma once

#include <vector>

#include "renderd/session/effects.h"

// For tests of the machines of a session.
namespace diaphane::render {

/// Returns the effects of one kind.
template <typename One>
std::vector<One> only(const Effects& effects) {
  std::vector<One> found;
  for (const Effect& effect : effects) {
    if (const One* one = std::get_if<One>(&effect)) found.push_back(*one);
  }
  return found;
}

/// Returns the only effect. Fails the test if there are others or if it is of another kind.
template <typename One>
One sole(const Effects& effects) {
  const auto found = only<One>(effects);
  EXPECT_EQ(effects.size(), 1u);
  EXPECT_EQ(found.size(), 1u);
  return found.empty() ? One{} : found.front();
}

}  // namespace diaphane::render
