#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "renderd/kernel/features.h"

namespace diaphane::render {

/// Which kernel an engine takes for a scene, where it can compile one for just the scene's features
/// (CUDA). Every kernel gives the same estimate, but not the same bits (docs/adr/0010).
enum class KernelChoice : std::uint8_t {
  kExact,        ///< the scene's own, compiled before the first sample: the bits depend on the
                 ///< scene alone
  kStandIn,      ///< what is there now, while the scene's own is compiled; a picture keeps the
                 ///< kernel with which it began
  kAheadOfTime,  ///< the smallest of those in the program
  kGeneral,      ///< the one that has all features
};

enum class KernelOrigin : std::uint8_t { kGeneral, kAheadOfTime, kForThisScene };

/// What the kernel that renders a picture is, and what the picture takes. Plain data for reports.
struct KernelReport {
  std::vector<std::string> compiled_in, left_out;  ///< names of features
  KernelOrigin origin = KernelOrigin::kAheadOfTime;
  double compile_milliseconds = 0;  ///< compiling or reading and loading; 0 ahead of time
  bool from_cache = false;          ///< read from disk instead of compiled
  /// Of a GPU's kernel: registers a thread, and bytes a thread that do not fit into them.
  std::optional<int> registers;
  std::optional<std::uint64_t> local_bytes;
  /// The denoiser's kernels for the last picture, on the device's clock; nothing where none ran.
  std::optional<double> denoise_milliseconds;
  double empty_cells = 0;  ///< share of the macrocells that are skipped as empty
  std::uint64_t volume_bytes = 0, acceleration_bytes = 0, film_bytes = 0;  ///< on the device
  std::uint64_t shared_bytes = 0;  ///< working memory there, one for all sessions
  std::string note;                ///< why no kernel was compiled though one should have been
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

/// Fills in what `features` has and has not.
inline void list_features(Features features, KernelReport& report) {
  for (std::uint32_t i = 0; i < kFeatureCount; ++i) {
    auto& list = features.has(static_cast<Feature>(i)) ? report.compiled_in : report.left_out;
    list.emplace_back(kFeatureNames[i]);
  }
}

}  // namespace diaphane::render
