#include "renderd/session/coarse_view.h"

namespace diaphane::render {

void with_coarse_view(const CoarseVolume& coarse, const diaphane::v1::Scene& scene, Canvas canvas,
                      const std::function<void(const CoarseView&)>& use) {
  diaphane::v1::Scene dark = scene;  // lights do not matter here, and their textures take time
  dark.clear_lights();
  dark.mutable_camera()->set_aperture_radius(0);
  const volume::Header& header = coarse.volume.header;
  const auto prepared = prepare_scene(dark, canvas, header, coarse.grid);
  if (!prepared) return;
  const PreparedTransfer& t = *prepared->transfer;
  CoarseView view = view_of(*prepared, LinearVolume{coarse.volume.voxels.data(), size_of(header)},
                            t.extinction.data(), t.colour.data(), bounds_of(*prepared).data(),
                            LightArrays(*prepared), 0);
  if (prepared->labels) {
    view.labels = {coarse.volume.label_set.labels.voxels.data(), prepared->labels->looks.data()};
  }
  use(view);
}

}  // namespace diaphane::render
