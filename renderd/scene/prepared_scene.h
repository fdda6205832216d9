#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "api/proto/scene.pb.h"
#include "common/result.h"
#include "renderd/film/canvas.h"
#include "renderd/kernel/features.h"
#include "renderd/kernel/method.h"
#include "renderd/kernel/views.h"
#include "renderd/math/random.h"
#include "renderd/scene/grid.h"
#include "renderd/scene/labels.h"
#include "renderd/scene/light_textures.h"
#include "renderd/scene/overlay.h"
#include "renderd/scene/transfer.h"
#include "volume/volume.h"

namespace diaphane::render {

/// A checked scene as plain arrays in the volume's frame: everything that an engine uploads. Both
/// engines use it, so that a scene means the same on both.
struct PreparedScene {
  Features features;
  /// The same pointer as in the previous scene if the transfer function is the same, so that an
  /// engine need not upload it again.
  std::shared_ptr<const PreparedTransfer> transfer;
  /// Shared like `transfer`; null if labels change nothing.
  std::shared_ptr<const PreparedLabels> labels;
  /// Null if only one scan is shown.
  std::shared_ptr<const PreparedOverlay> overlay;
  std::vector<AreaLight> lights;
  Float3 environment{};              ///< sum of the environment lights without a texture
  std::vector<EnvironmentMap> maps;  ///< environment lights with a texture
  /// Shared like `transfer`; null if no light has a texture.
  std::shared_ptr<const PreparedTextures> textures;
  bool maps_visible = false;  ///< environment maps are visible to camera rays
  CameraView camera{};
  ClipView clip{};
  SlicesView slices{};
  HighlightView highlight{};
  bool matter = true;         ///< false: there are only slices, and no ray is traced
  float phase_g = 0;          ///< g of Henyey-Greenstein, between -1 and 1
  float surfaces = 0;         ///< SceneView::surfaces
  std::uint32_t bounces = 1;  ///< SceneView::bounces
  Float3 escape{};
  Float3 escape_edge{};  ///< as in SceneView
  Canvas canvas;
  Float3 spacing{};                 ///< mm
  Float3 middle{};                  ///< centre of the volume in its frame, mm
  double exposure = 0;              ///< stops: the display multiplies the radiance by 2^exposure
  bool automatic_exposure = false;  ///< whether automatic_stops() are added to it
  ToneCurve curve = ToneCurve::kLinear;  ///< tone curve of the display
};

/// Checks a scene and prepares it for a volume. Fails with kInvalid and the name of the field.
/// `before` may be the scene that was prepared last, and `before_scene` the message that
/// it was prepared from. If `before` is of another volume, only its textures are reused, and
/// `before_scene` must be null. `baked`, if not null, keeps the transfer functions of the volume.
/// `second` is the session's second scan, or null.
Result<PreparedScene> prepare_scene(const diaphane::v1::Scene& scene, Canvas canvas,
                                    const volume::Header& header, const ValueGrid& grid,
                                    const PreparedScene* before = nullptr,
                                    const diaphane::v1::Scene* before_scene = nullptr,
                                    TransferCache* baked = nullptr,
                                    const SecondScan* second = nullptr);

/// Returns whether directions sampled from the scattering of the scene's matter are samples of its
/// lights too. See kMixes, which is the same for the features of the kernel.
inline bool mixes(const PreparedScene& scene) {
  return scene.features.has(Feature::kAnisotropicPhase) || scene.features.has(Feature::kSurfaces);
}

/// Returns how many collisions of a camera ray sample light by each strategy (ExactView::strata).
std::array<std::int32_t, kHitKinds> strata_for(const PreparedScene& scene);

/// Returns the bounds of the extinction in each macrocell, of the first scan and of all matter.
inline const std::vector<CellBounds>& first_bounds_of(const PreparedScene& scene) {
  return scene.labels ? scene.labels->bounds : scene.transfer->bounds;
}
inline const std::vector<CellBounds>& bounds_of(const PreparedScene& scene) {
  return scene.overlay ? scene.overlay->bounds : first_bounds_of(scene);
}

/// Returns whether the scene is rendered by the exact walk instead of tracking. The walk cannot
/// follow the extinction of labels, which jumps between the centres of voxels, or that of a second
/// scan with other voxels.
bool use_exact_walk(const PreparedScene& scene, Method method);

/// Returns the view of the exact walk's tables. `pieces`, `piece_of` and `skips` point to the
/// vectors of ExactTables or to an executor's copies of them.
inline ExactView exact_view_of(const PreparedScene& scene, const ValueGrid& grid, Int3 size,
                               const ExtinctionPiece* pieces, const std::uint16_t* piece_of,
                               const std::uint8_t* skips) {
  const ExactTables& t = scene.transfer->exact;
  const auto strata = strata_for(scene);
  const BrickArray bricks(grid.bricks);
  return {.pieces = pieces,
          .piece_of = piece_of,
          .piece_count = static_cast<std::int32_t>(t.pieces.size()),
          .first_value = grid.whole.minimum,
          .last_value = grid.whole.maximum,
          .only = t.pieces.empty() ? ExtinctionPiece{} : t.pieces.front(),
          .size = size,
          .brick_row = bricks.row,
          .brick_slice = bricks.slice,
          .brick_count = bricks.count,
          .skips = skips == nullptr ? nullptr : skips + bricks.first,
          .strata = {strata[0], strata[1], strata[2], strata[3], strata[4]}};
}

/// An executor's copies of a scene's lights. All except the first may be null if no light has a
/// texture.
struct LightArrays {
  const AreaLight* area = nullptr;
  const EnvironmentMap* maps = nullptr;
  const LightTexture* textures = nullptr;
  const Float4* texels = nullptr;
  const float* rows = nullptr;

  LightArrays(const AreaLight* lights) : area(lights) {}  // NOLINT: a scene without a texture
  /// Uses the scene's own arrays.
  explicit LightArrays(const PreparedScene& scene) : area(scene.lights.data()) {
    if (!scene.textures) return;
    maps = scene.maps.data();
    textures = scene.textures->textures.data();
    texels = scene.textures->texels.data();
    rows = scene.textures->rows.data();
  }
};

inline LightsView view_of(const PreparedScene& scene, const LightArrays& lights) {
  return {.area = lights.area,
          .count = static_cast<std::uint32_t>(scene.lights.size()),
          .environment = scene.environment,
          .map_count = static_cast<std::uint32_t>(scene.maps.size()),
          .maps = lights.maps,
          .textures = lights.textures,
          .texels = lights.texels,
          .rows = lights.rows,
          .maps_visible = scene.maps_visible};
}

/// Returns the view of a prepared scene over an executor's copies of its arrays. The caller sets
/// the pointers of the tables of gloss and emission, of labels and of the exact walk in the view if
/// it has them, and calls add_overlay() if there is a second scan.
template <typename Volume>
SceneView<Volume> view_of(const PreparedScene& scene, const Volume& volume, const float* extinction,
                          const Float4* colour, const CellBounds* bounds, const LightArrays& lights,
                          std::uint64_t seed, std::uint64_t first_sample = 0, Method method = {}) {
  const PreparedTransfer& t = *scene.transfer;
  const Float3 s = scene.spacing;
  const Box occupied = scene.overlay  ? scene.overlay->occupied
                       : scene.labels ? scene.labels->occupied
                                      : t.occupied;
  OverlayView<Volume> overlay{};
  overlay.first_share = 1;
  overlay.first_in_slices = 1;
  return SceneView<Volume>{.volume = volume,
                           .inverse_spacing = {1.0f / s.x, 1.0f / s.y, 1.0f / s.z},
                           .spacing = s,
                           .transfer = {extinction, colour, t.scale, t.offset, t.margin, t.count},
                           .grid = {bounds, t.cells, scene.matter ? occupied : Box{}},
                           .exact = {},
                           .lights = view_of(scene, lights),
                           .camera = scene.camera,
                           .clip = scene.clip,
                           .slices = scene.slices,
                           .labels = {},
                           .highlight = scene.highlight,
                           .overlay = overlay,
                           .phase_g = scene.phase_g,
                           .surfaces = scene.surfaces,
                           .bounces = scene.bounces,
                           .roulette = method.roulette,
                           .escape = scene.escape,
                           .escape_edge = scene.escape_edge,
                           .width = scene.canvas.width,
                           .height = scene.canvas.height,
                           .first_row = scene.canvas.first_row,
                           .picture_height = scene.canvas.picture_height(),
                           .seed = seed,
                           .first_sample = first_sample,
                           .stream = mix64(seed + mix64(first_sample)),
                           .independent_points = !method.low_discrepancy,
                           // A kernel with more features than the scene needs must not combine
                           // light samples with scattering directions that are not sampled.
                           .mis = mixes(scene) ? method.mis : Mis::kLight,
                           .walk = method.walk,
                           .numbers = {}};
}

/// The second scan's arrays in the memory of an executor. Gloss and emission may be null.
struct OverlayArrays {
  const float* extinction;
  const Float4* colour;
  const Float4* gloss;
  const Float4* emission;
  const float* majorants;
};

/// Adds the second scan to the view of a scene that has one.
template <typename Volume>
void add_overlay(const PreparedScene& scene, const Volume& volume, const OverlayArrays& arrays,
                 SceneView<Volume>& view) {
  const OverlayView<LinearVolume>& from = scene.overlay->view;
  const PreparedTransfer& t = *scene.overlay->transfer;
  view.overlay = {.volume = volume,
                  .transfer = {arrays.extinction, arrays.colour, t.scale, t.offset, t.margin,
                               t.count, arrays.gloss, arrays.emission},
                  .map = from.map,
                  .majorants = arrays.majorants,
                  .step = from.step,
                  .surfaces = from.surfaces,
                  .per_extinction = from.per_extinction,
                  .first_share = from.first_share,
                  .second_share = from.second_share,
                  .first_in_slices = from.first_in_slices,
                  .second_in_slices = from.second_in_slices,
                  .split = from.split,
                  .split_column = from.split_column};
}

}  // namespace diaphane::render
