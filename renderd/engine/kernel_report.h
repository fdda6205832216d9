#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "renderd/kernel/features.h"

namespace diaphane::render {

/// Which kernel an engine uses for a scene if it can compile one for exactly the features of the
/// scene (CUDA). Every kernel gives the same estimate, but not the same bits (docs/adr/0010).
enum class KernelChoice : std::uint8_t {
  kExact,    ///< the scene's own kernel, compiled before the first sample, so that the bits depend
             ///< only on the scene
  kStandIn,  ///< the best available kernel while the scene's own is compiled; a picture keeps the
             ///< kernel with which it began
  kAheadOfTime,  ///< the smallest suitable kernel in the program
  kGeneral,      ///< the kernel with all features
};

enum class KernelOrigin : std::uint8_t { kGeneral, kAheadOfTime, kForThisScene };

/// Describes the kernel that renders a picture, and the memory that the picture takes.
struct KernelReport {
  std::vector<std::string> compiled_in, left_out;  ///< names of features
  KernelOrigin origin = KernelOrigin::kAheadOfTime;
  double compile_milliseconds = 0;  ///< time to compile, or to read and load; 0 if ahead of time
  bool from_cache = false;          ///< read from disk instead of compiled
  /// Registers per thread of a GPU, and bytes per thread that do not fit into registers.
  std::optional<int> registers;
  std::optional<std::uint64_t> local_bytes;
  /// Duration of the denoiser's kernels for the last picture, measured by the device; empty if none
  /// ran.
  std::optional<double> denoise_milliseconds;
  double empty_cells = 0;  ///< fraction of the macrocells that are skipped as empty
  std::uint64_t volume_bytes = 0, acceleration_bytes = 0, film_bytes = 0;  ///< on the device
  std::uint64_t shared_bytes = 0;  ///< working memory on the device, shared by all sessions
  std::string note;                ///< why no kernel was compiled although one should have been
};

inline const char* name_of(KernelOrigin origin) {
  switch (origin) {
    case KernelOrigin::kGeneral:
      return "general";
    case KernelOrigin::kAheadOfTime:
      return "ahead of time";
    case KernelOrigin::kForThisScene:
      return "compiled for this scene";
  }
  return "";
}

/// Fills in the names of the features that `features` has and of those that it lacks.
inline void list_features(Features features, KernelReport& report) {
  for (std::uint32_t i = 0; i < kFeatureCount; ++i) {
    auto& list = features.has(static_cast<Feature>(i)) ? report.compiled_in : report.left_out;
    list.emplace_back(kFeatureNames[i]);
  }
}

}  // namespace diaphane::render
