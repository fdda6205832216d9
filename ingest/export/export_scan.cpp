#include "ingest/export/export_scan.h"

#include <algorithm>
#include <limits>

#include "common/try.h"
#include "ingest/export/mesh_writer.h"
#include "ingest/export/nifti_writer.h"

namespace diaphane::ingest {
namespace {

Result<Inside> inside_of(const volume::Volume& volume, const ExportOrder& order) {
  if (order.label.has_value() == order.above.has_value()) {
    return fail(ErrorCode::kInvalid, "a surface needs either a label or a threshold");
  }
  if (order.above) {
    if (*order.above > volume.header.maximum)
      return fail(ErrorCode::kInvalid, "no voxel has a value this high");
    // At or below the lowest value, the surface encloses the whole scan.
    const auto lowest = std::max<std::int32_t>(*order.above, volume.header.minimum);
    return Inside{0, static_cast<std::int16_t>(lowest)};
  }
  const auto& table = volume.label_set.table;
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (table[i].number == *order.label) return Inside{static_cast<std::uint8_t>(i + 1), 0};
  }
  return fail(ErrorCode::kInvalid, "the scan has no such label");
}

}  // namespace

std::optional<ExportFormat> export_format_of(std::string_view name) {
  if (name.ends_with(".nii")) return ExportFormat::kNifti;
  if (name.ends_with(".nii.gz")) return ExportFormat::kNiftiGz;
  if (name.ends_with(".stl")) return ExportFormat::kStl;
  if (name.ends_with(".glb")) return ExportFormat::kGlb;
  return std::nullopt;
}

Result<void> export_scan(const volume::Volume& volume, const ExportOrder& order,
                         const SurfaceLimits& limits, const Sink& sink) {
  if (order.format == ExportFormat::kNifti || order.format == ExportFormat::kNiftiGz) {
    if (order.label || order.above) {
      return fail(ErrorCode::kInvalid,
                  "NIfTI contains the whole scan, so it has no label and no threshold");
    }
    return write_nifti(volume.header, volume.voxels, order.format == ExportFormat::kNiftiGz, sink);
  }
  if (order.above && volume.voxels.size() != volume.header.voxel_count()) {
    return fail(ErrorCode::kInternal, "a surface is that of one phase");
  }
  const auto inside = inside_of(volume, order);
  DIAPHANE_TRY(inside);
  const auto mesh = make_surface(volume, *inside, limits);
  DIAPHANE_TRY(mesh);
  return order.format == ExportFormat::kStl ? write_stl(*mesh, sink) : write_glb(*mesh, sink);
}

}  // namespace diaphane::ingest
