#include <algorithm>

#include "ingest/head/signs.h"

namespace diaphane::ingest {
namespace {

constexpr float kBone = 250;  // HU; partial volume lowers the values of thin bone
constexpr float kSoftLow = -30, kSoftHigh = 130;  // HU: brain, blood, fluid
constexpr double kLeastArea = 3000;               // mm^2, an infant's brain slightly above its base
constexpr double kLeastSide = 50, kMostSide = 220;  // mm
constexpr double kLeastSoft = 0.6;                  // share of the enclosed area
constexpr int kLeastCaseLevels = 8;                 // consecutive levels: 24 mm

struct CaseLevel {
  Mask enclosed;
  bool fits = false;
};

/// Dilates a mask by one cell in all eight directions.
Mask grown(const Mask& mask, int width, int height) {
  Mask larger(mask.size(), 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (!mask[static_cast<std::size_t>(x + width * y)]) continue;
      for (int ny = std::max(0, y - 1); ny <= std::min(height - 1, y + 1); ++ny) {
        for (int nx = std::max(0, x - 1); nx <= std::min(width - 1, x + 1); ++nx) {
          larger[static_cast<std::size_t>(nx + width * ny)] = 1;
        }
      }
    }
  }
  return larger;
}

/// Returns a mask of bone, dilated by one cell, so that sutures and the thin roof of the orbit do
/// not count as openings.
Mask grown_bone(const Coarse& coarse, int z) {
  Mask bone(coarse.cells_of_level());
  const std::size_t first = coarse.at(0, 0, z);
  for (std::size_t i = 0; i < bone.size(); ++i) bone[i] = coarse.most[first + i] >= kBone;
  return grown(bone, coarse.size[0], coarse.size[1]);
}

/// Marks cells that see bone in nearly all directions of the level. A hole in the shell, from a
/// fracture or an operation, hides bone in some directions, so a shell with a hole is still found.
Mask enclosed_by(const Mask& bone, int width, int height) {
  constexpr std::array<std::array<int, 2>, 16> kDirections{{{1, 0},
                                                            {-1, 0},
                                                            {0, 1},
                                                            {0, -1},
                                                            {1, 1},
                                                            {-1, 1},
                                                            {1, -1},
                                                            {-1, -1},
                                                            {2, 1},
                                                            {-2, 1},
                                                            {2, -1},
                                                            {-2, -1},
                                                            {1, 2},
                                                            {-1, 2},
                                                            {1, -2},
                                                            {-1, -2}}};
  constexpr int kLeastSeen = 14;
  std::vector<int> hits(bone.size(), 0);
  Mask hit(bone.size());
  for (const auto& [dx, dy] : kDirections) {
    // Walks against the direction, so that the result of the next cell is known and no ray is
    // walked twice.
    for (int row = 0; row < height; ++row) {
      const int y = dy > 0 ? height - 1 - row : row;
      for (int column = 0; column < width; ++column) {
        const int x = dx > 0 ? width - 1 - column : column;
        const int nx = x + dx, ny = y + dy;
        const auto cell = static_cast<std::size_t>(x + width * y);
        const bool within = nx >= 0 && nx < width && ny >= 0 && ny < height;
        const auto next = within ? static_cast<std::size_t>(nx + width * ny) : 0;
        hit[cell] = within && (bone[next] || hit[next]);
        hits[cell] += hit[cell];
      }
    }
  }
  Mask enclosed(bone.size());
  for (std::size_t i = 0; i < bone.size(); ++i) enclosed[i] = !bone[i] && hits[i] >= kLeastSeen;
  return enclosed;
}

CaseLevel look_at(const Coarse& coarse, int z) {
  const int width = coarse.size[0], height = coarse.size[1];
  const std::size_t first = coarse.at(0, 0, z);
  CaseLevel level{enclosed_by(grown_bone(coarse, z), width, height), false};
  const std::size_t cells = keep_largest(level.enclosed, width, height);
  if (static_cast<double>(cells) * Coarse::kCellMm * Coarse::kCellMm < kLeastArea) return level;

  int low_x = width, high_x = -1, low_y = height, high_y = -1;
  std::size_t soft = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto cell = static_cast<std::size_t>(x + width * y);
      if (!level.enclosed[cell]) continue;
      low_x = std::min(low_x, x), high_x = std::max(high_x, x);
      low_y = std::min(low_y, y), high_y = std::max(high_y, y);
      const float value = coarse.mean[first + cell];
      soft += value >= kSoftLow && value <= kSoftHigh;
    }
  }
  const double across = (high_x - low_x + 1) * Coarse::kCellMm;
  const double deep = (high_y - low_y + 1) * Coarse::kCellMm;
  level.fits = std::min(across, deep) >= kLeastSide && std::max(across, deep) <= kMostSide &&
               static_cast<double>(soft) >= kLeastSoft * static_cast<double>(cells);
  return level;
}

}  // namespace

std::optional<Brain> find_brain_case(const Coarse& coarse) {
  std::vector<CaseLevel> levels;
  int begin = 0, best_begin = 0, best_count = 0;
  for (int z = 0; z < coarse.size[2]; ++z) {
    levels.push_back(look_at(coarse, z));
    if (!levels.back().fits) begin = z + 1;
    if (z + 1 - begin > best_count) {
      best_begin = begin;
      best_count = z + 1 - begin;
    }
  }
  if (best_count < kLeastCaseLevels) return std::nullopt;

  Brain brain;
  const auto take = [&](int z, const Mask& allowed) {
    Mask& enclosed = levels[static_cast<std::size_t>(z)].enclosed;
    const std::size_t before = brain.size();
    for (int y = 0; y < coarse.size[1]; ++y) {
      for (int x = 0; x < coarse.size[0]; ++x) {
        const auto cell = static_cast<std::size_t>(x + coarse.size[0] * y);
        enclosed[cell] = enclosed[cell] && allowed[cell];
        if (enclosed[cell]) brain.push_back(coarse.place(x, y, z));
      }
    }
    return brain.size() > before;
  };
  const auto mask = [&](int z) -> const Mask& {
    return levels[static_cast<std::size_t>(z)].enclosed;
  };
  // From the vault down, each level may be at most one cell wider than the one above. Other
  // enclosed regions are an orbit or a mouth, and keeping these would keep the face.
  const int top = best_begin + best_count - 1;
  take(top, Mask(coarse.cells_of_level(), 1));
  for (int z = top - 1; z >= best_begin; --z) {
    take(z, grown(mask(z + 1), coarse.size[0], coarse.size[1]));
  }
  // Adds the levels above, whose cross-sections are too small to count as a brain.
  for (int z = top + 1; z < coarse.size[2] && take(z, mask(z - 1)); ++z) {
  }
  for (int z = best_begin - 1; z >= 0 && take(z, mask(z + 1)); --z) {
  }
  return brain;
}

}  // namespace diaphane::ingest
