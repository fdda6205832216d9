#pragma once

#include <functional>

#include "renderd/kernel/views.h"
#include "renderd/scene/prepared_scene.h"
#include "renderd/session/depth.h"

namespace diaphane::render {

/// A scene with a coarse volume as the kernel sees it.
using CoarseView = SceneView<LinearVolume>;

/// Calls `use` with the scene, or not at all if it cannot be prepared. Lights are left out.
/// Precondition: `scene` has passed check_scene.
void with_coarse_view(const CoarseVolume& coarse, const CoarseSecond& second,
                      const diaphane::v1::Scene& scene, Canvas canvas,
                      const std::function<void(const CoarseView&)>& use);

}  // namespace diaphane::render
