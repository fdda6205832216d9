#include "common/try.h"
#include "renderd/engine/cuda/renderer.h"

// CudaRenderer: other volumes, and the second scan of a session.

namespace diaphane::render::cuda {
namespace {

bool same_cells(Int3 a, Int3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

}  // namespace

Result<void> CudaRenderer::set_volume(std::shared_ptr<const DeviceVolume> volume) {
  auto ours = std::dynamic_pointer_cast<const CudaVolume>(std::move(volume));
  if (!ours || ours->device() != volume_->device()) {
    return fail(ErrorCode::kInternal, "the volume was loaded by another engine");
  }
  next_volume_ = std::move(ours);
  return {};
}

Result<void> CudaRenderer::set_second(std::shared_ptr<const DeviceVolume> volume,
                                      const volume::Matrix& to_first) {
  auto ours = std::dynamic_pointer_cast<const CudaVolume>(volume);
  if (volume && (!ours || ours->device() != volume_->device())) {
    return fail(ErrorCode::kInternal, "the volume was loaded by another engine");
  }
  next_second_ = {std::move(ours), to_first};
  return {};
}

std::optional<SecondScan> CudaRenderer::second_scan() const {
  const auto& v = next_second_.volume;
  if (!v) return std::nullopt;
  return SecondScan{.header = v->header(),
                    .grid = v->grid(),
                    .to_first = next_second_.to_first,
                    .baked = v->always_baked(),
                    .as_before = next_second_ == second_};
}

Result<void> CudaRenderer::upload_second(const PreparedScene& prepared) {
  const PreparedOverlay& overlay = *prepared.overlay;
  const PreparedTransfer& transfer = *overlay.transfer;
  const cudaStream_t stream = stream_.get();
  SecondTables& tables = second_tables_;
  if (!same_cells(tables.acceleration.cells(), second_.volume->grid().cells)) {
    tables.acceleration = {};
  }
  auto acceleration = Acceleration::reserve(tables.acceleration, *second_.volume, transfer);
  DIAPHANE_TRY(acceleration);
  if (acceleration->made()) tables.acceleration = std::move(*acceleration);
  DIAPHANE_TRY(ensure(tables.colour, transfer.colour.size()));
  DIAPHANE_TRY(upload(tables.colour, transfer.colour.data(), transfer.colour.size(), stream));
  if (!transfer.gloss.empty()) {
    DIAPHANE_TRY(ensure(tables.gloss, transfer.gloss.size()));
    DIAPHANE_TRY(upload(tables.gloss, transfer.gloss.data(), transfer.gloss.size(), stream));
  }
  if (!transfer.emission.empty()) {
    DIAPHANE_TRY(ensure(tables.emission, transfer.emission.size()));
    DIAPHANE_TRY(
        upload(tables.emission, transfer.emission.data(), transfer.emission.size(), stream));
  }
  DIAPHANE_TRY(
      tables.acceleration.rebuild_acceleration(*second_.volume, transfer, nullptr, stream));
  return tables_.acceleration.add_second(tables.acceleration, overlay, stream);
}

OverlayArrays CudaRenderer::second_arrays() const {
  const PreparedTransfer& transfer = *prepared_.overlay->transfer;
  const SecondTables& tables = second_tables_;
  return {.extinction = tables.acceleration.extinction(),
          .colour = tables.colour.data(),
          .gloss = transfer.gloss.empty() ? nullptr : tables.gloss.data(),
          .emission = transfer.emission.empty() ? nullptr : tables.emission.data(),
          .majorants = tables_.acceleration.majorants()};
}

}  // namespace diaphane::render::cuda
