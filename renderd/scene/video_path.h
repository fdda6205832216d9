#pragma once

#include <cstdint>
#include <vector>

#include "api/proto/scene.pb.h"
#include "api/proto/stream.pb.h"
#include "common/result.h"

// What each frame of a video shows (thesis 6.2), as a pure function of its key views.

namespace diaphane::render {

/// Limits of the frames of a video and of a large picture.
inline constexpr std::uint32_t kShortestFileSide = 16;
inline constexpr double kLeastFileError = 0.005;
inline constexpr std::size_t kMostKeyViews = 16;
inline constexpr std::uint32_t kLongestVideoSide = 1920;
inline constexpr std::uint32_t kLongestVideoSeconds = 60;

/// Turns the camera by `turn` full rotations about the patient's axis from foot to head, through
/// the camera's target.
diaphane::v1::Scene turned_about_target(const diaphane::v1::Scene& scene, double turn);

/// Returns the scene between two key views, at `at` in [0, number of keys - 1]. Whole numbers are
/// the keys themselves.
///
/// The camera follows a centripetal Catmull-Rom curve (Barry and Goldman 1988; Yuksel et al. 2011:
/// no cusps, no loops within a segment): its target in space, its distance by the logarithm, its
/// direction on the sphere of rotations. The rest of the scene changes linearly, slowly near the
/// keys, part by part where the two scenes have equal kinds of parts (the same lights, channels and
/// points). Otherwise it changes halfway.
diaphane::v1::Scene on_tour(const std::vector<diaphane::v1::Scene>& keys, double at);

/// Checks the request of a video of a scan with `phases` phases. Fails with kInvalid and the name
/// of the wrong field or key view.
Result<void> check_video(const diaphane::v1::Video& video,
                         const std::vector<diaphane::v1::Scene>& keys, std::uint32_t phases = 1);

/// Returns frame `index` of a video that has passed check_video(). The last frame of a turntable is
/// one step before its first one, so that it loops seamlessly. The last frame of a tour is its last
/// key. If the phases are played, each is shown equally long, and the last frame shows the last
/// one.
diaphane::v1::Scene video_frame(const diaphane::v1::Video& video,
                                const std::vector<diaphane::v1::Scene>& keys, std::uint32_t index,
                                std::uint32_t phases = 1);

}  // namespace diaphane::render
