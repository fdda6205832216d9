#include "renderd/session/coarse_view.h"

#include <optional>

namespace diaphane::render {

void with_coarse_view(const CoarseVolume& coarse, const CoarseSecond& second,
                      const diaphane::v1::Scene& scene, Canvas canvas,
                      const std::function<void(const CoarseView&)>& use) {
  diaphane::v1::Scene dark = scene;  // lights do not matter here, and their textures take time
  dark.clear_lights();
  dark.mutable_camera()->set_aperture_radius(0);
  const volume::Header& header = coarse.volume.header;
  std::optional<SecondScan> over;
  if (const auto& v = second.volume) {
    over.emplace(SecondScan{v->volume.header, v->grid, second.to_first});
  }
  const auto prepared = prepare_scene(dark, canvas, header, coarse.grid, nullptr, nullptr, nullptr,
                                      over ? &*over : nullptr);
  if (!prepared) return;
  const PreparedTransfer& t = *prepared->transfer;
  CoarseView view = view_of(*prepared, LinearVolume{coarse.volume.voxels.data(), size_of(header)},
                            t.extinction.data(), t.colour.data(), bounds_of(*prepared).data(),
                            LightArrays(*prepared), 0);
  if (prepared->labels) {
    view.labels = {coarse.volume.label_set.labels.voxels.data(), prepared->labels->looks.data()};
  }
  if (prepared->overlay) {
    const volume::Volume& v = second.volume->volume;
    const PreparedTransfer& o = *prepared->overlay->transfer;
    add_overlay(*prepared, LinearVolume{v.voxels.data(), size_of(v.header)},
                {o.extinction.data(), o.colour.data(), nullptr, nullptr,
                 prepared->overlay->majorants.data()},
                view);
  }
  use(view);
}

}  // namespace diaphane::render
