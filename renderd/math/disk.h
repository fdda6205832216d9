#pragma once

#include "renderd/math/vector.h"

namespace diaphane::render {

struct DiskPoint {
  float x, y;
};

/// Maps (u, v) in [0, 1]^2 uniformly onto the unit disk. The map is concentric (Shirley and Chiu
/// 1997, in Cline's form): squares become rings, so points that cover the square evenly also cover
/// the disk evenly.
HOST_DEVICE DiskPoint sample_disk(float u, float v) {
  constexpr float kQuarter = 0.785398163f;  // pi / 4
  const float a = 2.0f * u - 1.0f, b = 2.0f * v - 1.0f;
  const bool flat = a * a > b * b;
  const float radius = flat ? a : b;
  if (radius == 0.0f) return {0.0f, 0.0f};
  const float turn = kQuarter * (flat ? b / a : a / b);
  const float along = radius * cosf(turn), across = radius * sinf(turn);
  return flat ? DiskPoint{along, across} : DiskPoint{across, along};
}

}  // namespace diaphane::render
