#pragma once

#include <string>
#include <string_view>

// Names that the operator uses in Kubernetes and in Redis. The schemas of its custom resources are
// in helm/diaphane/crds.

namespace diaphane::fleet {

inline constexpr std::string_view kGroup = "diaphane.dev";
inline constexpr const char* kVersion = "diaphane.dev/v1alpha1";
inline constexpr const char* kFinalizer = "diaphane.dev/drain";
inline constexpr const char* kFleetLabel = "diaphane.dev/fleet";
inline constexpr const char* kWorkerLabel = "diaphane.dev/worker";
inline constexpr const char* kEpochAnnotation = "diaphane.dev/epoch";
inline constexpr const char* kManager = "diaphane-operator";
inline constexpr const char* kGpu = "nvidia.com/gpu";
inline constexpr const char* kContainer = "renderd";

/// Identifies the owner of a worker in Redis: its fleet, the uid of its RenderWorker, and the epoch
/// of its pod ("skull/7f.../3"). renderd sends this text after each heartbeat. Only workers of the
/// same fleet help each other.
inline std::string owner_text(const std::string& fleet, const std::string& uid, long long epoch) {
  return fleet + "/" + uid + "/" + std::to_string(epoch);
}

}  // namespace diaphane::fleet
