#pragma once

#include <cstdint>
#include <vector>

#include "api/proto/scene.pb.h"
#include "api/proto/stream.pb.h"
#include "common/result.h"

// What each frame of a film shows (thesis 6.2): a pure function of its key views.

namespace diaphane::render {

/// Of a frame, and of a large picture.
inline constexpr std::uint32_t kShortestFileSide = 16;
inline constexpr double kLeastFileError = 0.005;
inline constexpr std::size_t kMostKeyViews = 16;
inline constexpr std::uint32_t kLongestFilmSide = 1920;
inline constexpr std::uint32_t kLongestFilmSeconds = 60;

/// `turn` of a whole one about the patient's axis from foot to head, through the camera's target.
diaphane::v1::Scene turned_about_target(const diaphane::v1::Scene& scene, double turn);

/// The way from one key view to the next, at `at` of [0, number of keys - 1]; whole numbers are the
/// keys themselves.
///
/// The camera goes on a centripetal Catmull-Rom curve (Barry and Goldman 1988; Yuksel et al. 2011:
/// no cusps, no loops within a segment): its target in space, its distance by its logarithm, its
/// direction on the sphere of rotations. What else is in the scenes goes over linearly, slow at the
/// keys, part by part where the two are equal in kind (the same lights, channels and points);
/// otherwise it changes half way.
diaphane::v1::Scene on_tour(const std::vector<diaphane::v1::Scene>& keys, double at);

/// kInvalid names what is wrong with the order, or with one of its key views.
Result<void> check_film(const diaphane::v1::Film& film,
                        const std::vector<diaphane::v1::Scene>& keys);

/// Frame `index` of a film that passed check_film. A turntable's last frame is one step before its
/// first, so that it can be played round and round; a tour's is its last key.
diaphane::v1::Scene film_frame(const diaphane::v1::Film& film,
                               const std::vector<diaphane::v1::Scene>& keys, std::uint32_t index);

}  // namespace diaphane::render
