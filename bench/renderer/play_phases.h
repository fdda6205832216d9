#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderd/engine/frame_renderer.h"

// How many phases of a beating heart a device shows per second, as while a viewer plays them: one
// sample per pixel, denoised, of a new phase each time.

namespace diaphane::render::bench {

struct PlayOptions {
  std::uint32_t cube = 256;  ///< voxels per axis
  std::uint32_t phases = 20;
  Canvas canvas{640, 360};
  std::string preset = "vessels";
  double seconds = 10;  ///< of playing, after all phases were shown once
};

struct PlayReport {
  double load = 0;  ///< seconds to load all phases
  std::uint64_t bytes = 0;
  double first_prepare = 0;  ///< median ms to prepare a phase that is shown for the first time
  double prepare = 0;        ///< median ms to prepare a phase that was shown before
  double picture = 0;        ///< median ms per phase, from its scene to its picture
  double slowest = 0;        ///< ms, 95th percentile
  double per_second = 0;     ///< phases per second
};

Result<PlayReport> play_phases(Engine& engine, const PlayOptions& options);

std::string play_text(const PlayReport& report, const EngineInfo& info, const PlayOptions& options);
std::string play_json(const PlayReport& report, const EngineInfo& info, const PlayOptions& options);

}  // namespace diaphane::render::bench
