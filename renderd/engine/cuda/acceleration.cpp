#include "renderd/engine/cuda/acceleration.h"

#include "common/try.h"
#include "renderd/kernel/tracking.h"

namespace diaphane::render::cuda {
namespace {

std::size_t cell_count(Int3 cells) {
  return static_cast<std::size_t>(cells.x) * static_cast<std::size_t>(cells.y) *
         static_cast<std::size_t>(cells.z);
}

}  // namespace

Result<Acceleration> Acceleration::reserve(const Acceleration& current, const CudaVolume& volume,
                                           const PreparedTransfer& transfer) {
  Acceleration made;
  const auto nodes =
      static_cast<std::size_t>(transfer.count) * static_cast<std::size_t>(rows_of(transfer.count));
  if (current.made() && current.maxima_.capacity() >= nodes) return made;
  made.cells_ = volume.grid().cells;
  made.size_ = volume.view().size;
  DIAPHANE_TRY(ensure(made.maxima_, nodes));
  DIAPHANE_TRY(ensure(made.minima_, nodes));
  DIAPHANE_TRY(ensure(made.bounds_, cell_count(made.cells_)));
  DIAPHANE_TRY(ensure(made.summary_, 1));
  if (const LabelGrid& labels = volume.grid().labels; !labels.empty()) {
    DIAPHANE_TRY(ensure(made.looks_, PreparedLabels{}.looks.size()));
    DIAPHANE_TRY(ensure(made.label_ranges_, labels.sets.size()));
  }
  return made;
}

Result<void> Acceleration::rebuild_acceleration(const CudaVolume& volume,
                                                const PreparedTransfer& transfer,
                                                const PreparedLabels* labels, cudaStream_t stream) {
  const TableRows table{maxima_.data(), minima_.data(), transfer.count};
  const ValueMapping mapping{volume.grid().whole.minimum, static_cast<double>(transfer.scale),
                             static_cast<double>(transfer.margin)};
  DIAPHANE_TRY(upload(maxima_, transfer.extinction.data(), static_cast<std::size_t>(transfer.count),
                      stream));
  DIAPHANE_TRY(upload(summary_, &kNothingFound, 1, stream));
  CellLabels cell_labels;
  if (labels != nullptr) {
    DIAPHANE_TRY(upload(looks_, labels->looks.data(), labels->looks.size(), stream));
    DIAPHANE_TRY(upload(label_ranges_, labels->ranges.data(), labels->ranges.size(), stream));
    cell_labels = {volume.label_sets(), label_ranges_.data()};
  }
  DIAPHANE_CUDA_TRY(fill_rows(table, stream));
  DIAPHANE_CUDA_TRY(bound_cells(volume.ranges(), cells_, table, mapping, cell_labels,
                                bounds_.data(), summary_.data(), stream));
  return download(&found_, summary_, 1, stream);
}

Result<void> Acceleration::add_second(const Acceleration& second, const PreparedOverlay& overlay,
                                      cudaStream_t stream) {
  DIAPHANE_TRY(ensure(majorants_, cell_count(cells_)));
  DIAPHANE_TRY(upload(summary_, &kNothingFound, 1, stream));
  const auto& view = overlay.view;
  const SecondCells cells{view.map,     second.bounds(), second.cells(),
                          overlay.size, view.split,      {view.first_share, view.second_share}};
  DIAPHANE_CUDA_TRY(
      cuda::add_second(cells, cells_, bounds_.data(), majorants_.data(), summary_.data(), stream));
  return download(&found_, summary_, 1, stream);
}

Result<void> Acceleration::rebuild_exact(const CudaVolume& volume, const ExactTables& tables,
                                         cudaStream_t stream) {
  DIAPHANE_TRY(ensure(pieces_, tables.pieces.size()));
  DIAPHANE_TRY(ensure(piece_of_, tables.piece_of.size()));
  DIAPHANE_TRY(ensure(clear_until_, tables.clear_until.size()));
  DIAPHANE_TRY(ensure(skips_, volume.skip_bytes()));
  DIAPHANE_TRY(upload(pieces_, tables.pieces.data(), tables.pieces.size(), stream));
  DIAPHANE_TRY(upload(piece_of_, tables.piece_of.data(), tables.piece_of.size(), stream));
  DIAPHANE_TRY(upload(clear_until_, tables.clear_until.data(), tables.clear_until.size(), stream));
  auto empty = volume.prepare_exact(clear_until_.data(), skips_.data(), stream);
  DIAPHANE_TRY(empty);
  empty_bricks_ = *empty;
  return {};
}

Box Acceleration::occupied() const {
  if (found_.occupied == 0) return {{0, 0, 0}, {0, 0, 0}};
  const auto begin = [this](int axis) { return static_cast<float>(found_.low[axis] * kCellSize); };
  const auto end = [this](int axis) {
    return static_cast<float>(min((found_.high[axis] + 1) * kCellSize, size_[axis]));
  };
  return {{begin(0), begin(1), begin(2)}, {end(0), end(1), end(2)}};
}

bool Acceleration::steep(Float3 spacing) const {
  return found_.widest * (kCellSize * length(spacing)) > 3 * kDeepCell;
}

double Acceleration::empty_cells() const {
  return 1 - static_cast<double>(found_.occupied) / static_cast<double>(cell_count(cells_));
}

std::uint64_t Acceleration::device_bytes() const {
  return maxima_.bytes() + minima_.bytes() + bounds_.bytes() + summary_.bytes() + pieces_.bytes() +
         piece_of_.bytes() + clear_until_.bytes() + skips_.bytes() + looks_.bytes() +
         label_ranges_.bytes() + majorants_.bytes();
}

}  // namespace diaphane::render::cuda
